#include "firmware/base/latest.h"

#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::Latest;

namespace {

/// A state whose parts belong together: word i is stamp + i.
struct Record {
  std::array<std::uint64_t, 20> words{};
  std::uint8_t tail = 0;  // the size is no multiple of a word

  explicit Record(std::uint64_t stamp) : tail(static_cast<std::uint8_t>(stamp)) {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = stamp + i;
  }
  Record() = default;

  bool Whole() const {
    bool whole = tail == static_cast<std::uint8_t>(words[0]);
    for (std::size_t i = 0; i < words.size(); ++i) whole = whole && words[i] == words[0] + i;
    return whole;
  }
};

}  // namespace

TEST_GROUP(Latest){};

TEST(Latest, IsTheDefaultBeforeTheFirstStore) {
  struct Seven {
    int value = 7;
  };
  const Latest<Seven> latest;
  std::uint64_t stores = 99;
  LONGS_EQUAL(7, latest.Load(&stores).value);
  LONGS_EQUAL(0, stores);
}

TEST(Latest, IsTheLastValueStoredAndCountsStores) {
  Latest<Record> latest;
  for (std::uint64_t i = 1; i <= 5; ++i) {
    latest.Store(Record(10 * i));
    std::uint64_t stores = 0;
    const Record record = latest.Load(&stores);
    LONGS_EQUAL(10 * i, record.words[0]);
    CHECK_TRUE(record.Whole());
    LONGS_EQUAL(i, stores);
  }
}

TEST(Latest, HoldsATypeSmallerThanAWord) {
  Latest<std::uint8_t> latest;
  latest.Store(200);
  LONGS_EQUAL(200, latest.Load());
}

TEST(Latest, AllocatesNothing) {
  Latest<Record> latest;
  const std::uint64_t before = adit::support::AllocationCount();
  latest.Store(Record(3));
  const Record record = latest.Load();
  LONGS_EQUAL(before, adit::support::AllocationCount());
  CHECK_TRUE(record.Whole());
}

TEST(Latest, IsNeverTornNorGoesBackForThreeReaders) {
#if defined(__SANITIZE_THREAD__)
  constexpr std::uint64_t kStores = 100'000;
#else
  constexpr std::uint64_t kStores = 1'000'000;
#endif
  struct Tally {
    std::uint64_t torn = 0, backwards = 0, miscounted = 0, last = 0;
  };
  Latest<Record> latest;
  std::array<Tally, 3> tallies;
  std::vector<std::thread> readers;
  for (Tally& tally : tallies) {
    readers.emplace_back([&latest, &tally] {
      std::uint64_t stores = 0;
      while (stores < kStores) {
        const Record record = latest.Load(&stores);
        if (stores == 0) continue;
        tally.torn += record.Whole() ? 0 : 1;
        tally.backwards += record.words[0] < tally.last ? 1 : 0;
        tally.miscounted += record.words[0] == 1000 * stores ? 0 : 1;
        tally.last = record.words[0];
      }
    });
  }
  for (std::uint64_t i = 1; i <= kStores; ++i) latest.Store(Record(1000 * i));
  for (std::thread& reader : readers) reader.join();
  for (const Tally& tally : tallies) {
    LONGS_EQUAL(0, tally.torn);
    LONGS_EQUAL(0, tally.backwards);
    LONGS_EQUAL(0, tally.miscounted);
    LONGS_EQUAL(1000 * kStores, tally.last);
  }
}
