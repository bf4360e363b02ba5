#include "firmware/base/ring.h"

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::DropOldestRing;

TEST_GROUP(Ring){};

TEST(Ring, GivesBackItemsInTheOrderTheyCame) {
  DropOldestRing<int, 4> ring;
  for (const int item : {1, 2, 3}) CHECK_FALSE(ring.Push(item).has_value());
  for (const int item : {1, 2, 3}) LONGS_EQUAL(item, ring.Pop().value_or(-1));
}

TEST(Ring, IsEmptyBeforeTheFirstPushAndAfterTheLastPop) {
  DropOldestRing<int, 2> ring;
  CHECK_FALSE(ring.Pop().has_value());
  ring.Push(1);
  ring.Pop();
  CHECK_FALSE(ring.Pop().has_value());
}

TEST(Ring, HoldsAsManyAsItSays) {
  DropOldestRing<int, 8> ring;
  for (int i = 0; i < 8; ++i) CHECK_FALSE(ring.Push(i).has_value());
  LONGS_EQUAL(8, ring.SizeApprox());
  CHECK_TRUE(ring.Push(8).has_value());
  LONGS_EQUAL(8, ring.SizeApprox());
}

TEST(Ring, GivesTheOldestBackToTheProducerWhenFull) {
  DropOldestRing<int, 2> ring;
  ring.Push(1);
  ring.Push(2);
  LONGS_EQUAL(1, ring.Push(3).value_or(-1));
  LONGS_EQUAL(2, ring.Push(4).value_or(-1));
  LONGS_EQUAL(3, ring.Pop().value_or(-1));
  LONGS_EQUAL(4, ring.Pop().value_or(-1));
  CHECK_FALSE(ring.Pop().has_value());
}

TEST(Ring, GoesRoundManyTimesAtEveryFill) {
  for (std::size_t fill = 1; fill <= 4; ++fill) {
    DropOldestRing<std::uint64_t, 4> ring;
    std::uint64_t in = 0, out = 0;
    for (; in < fill; ++in) ring.Push(in);
    for (; in < 100; ++in) {
      LONGS_EQUAL(out++, ring.Pop().value_or(999));
      CHECK_FALSE(ring.Push(in).has_value());
      LONGS_EQUAL(fill, ring.SizeApprox());
    }
  }
}

TEST(Ring, AllocatesNothing) {
  DropOldestRing<int, 2> ring;
  const std::uint64_t before = adit::support::AllocationCount();
  int dropped = 0;
  for (int i = 0; i < 10; ++i) dropped += ring.Push(i).has_value() ? 1 : 0;
  while (ring.Pop()) {
  }
  LONGS_EQUAL(before, adit::support::AllocationCount());
  LONGS_EQUAL(8, dropped);
}

namespace {

/// What a frame buffer is to the box: plain memory that belongs to whoever holds its pointer.
struct Buffer {
  std::uint64_t number = 0;
};

/// One producer, one consumer, as fast as they can. Every item must come out once, by Pop or by Push, each
/// way in order; the plain memory behind it is written by its owner only, which TSan watches.
template <std::size_t N>
void Stress(std::uint64_t items) {
  DropOldestRing<Buffer*, N> ring;
  constexpr std::size_t kBuffers = N + 4;  // in the ring, in each hand, and on the way back
  std::vector<Buffer> buffers(kBuffers);
  DropOldestRing<Buffer*, 16> back;  // the consumer returns buffers here; never full, for it has 16 places
  static_assert(kBuffers <= 16);
  std::vector<std::uint8_t> seen(items, 0);  // by the producer: dropped items
  std::vector<std::uint64_t> popped;         // by the consumer
  popped.reserve(items);
  std::atomic<bool> done{false};

  std::thread consumer([&] {
    for (;;) {
      const bool last = done.load(std::memory_order_acquire);  // before the Pop that finds nothing
      if (const auto item = ring.Pop()) {
        popped.push_back((*item)->number);
        (*item)->number = ~std::uint64_t{0};
        back.Push(*item);
      } else if (last) {
        return;
      }
    }
  });
  std::vector<Buffer*> free;
  for (Buffer& buffer : buffers) free.push_back(&buffer);
  std::uint64_t last_dropped = 0, dropped = 0, out_of_order = 0;
  for (std::uint64_t i = 1; i < items;) {
    while (const auto returned = back.Pop()) free.push_back(*returned);
    if (free.empty()) continue;
    Buffer* mine = free.back();
    free.pop_back();
    mine->number = i++;
    if (const auto oldest = ring.Push(mine)) {
      if ((*oldest)->number <= last_dropped) ++out_of_order;
      last_dropped = (*oldest)->number;
      ++seen[last_dropped];
      ++dropped;
      free.push_back(*oldest);
    }
  }
  // release: the last Push stands before it.
  done.store(true, std::memory_order_release);
  consumer.join();

  std::uint64_t last = 0;
  for (const std::uint64_t number : popped) {
    if (number <= last) ++out_of_order;
    last = number;
    ++seen[number];
  }
  std::uint64_t not_once = 0;
  for (std::uint64_t i = 1; i < items; ++i) not_once += seen[i] == 1 ? 0 : 1;
  LONGS_EQUAL(0, out_of_order);
  LONGS_EQUAL(0, not_once);
  LONGS_EQUAL(items - 1, dropped + popped.size());
}

#if defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kItems = 300'000;  // some 20 times slower there
#else
constexpr std::uint64_t kItems = 3'000'000;
#endif

}  // namespace

TEST(Ring, OfTwoHandsEveryItemOverExactlyOnce) { Stress<2>(kItems); }

TEST(Ring, OfEightHandsEveryItemOverExactlyOnce) { Stress<8>(kItems); }
