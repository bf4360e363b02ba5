#include "firmware/base/conveyor.h"

#include <cstdint>
#include <thread>

#include <CppUTest/TestHarness.h>

using adit::base::Conveyor;

TEST_GROUP(Conveyor){};

TEST(Conveyor, HandsOverInOrder) {
  Conveyor<int, 4> conveyor;
  for (const int value : {1, 2, 3}) {
    conveyor.Draft() = value;
    CHECK(conveyor.Commit() == nullptr);
  }
  for (const int value : {1, 2, 3}) {
    int* const got = conveyor.Pop();
    CHECK(got != nullptr);
    LONGS_EQUAL(value, *got);
    conveyor.GiveBack(got);
  }
  CHECK(conveyor.Pop() == nullptr);
}

TEST(Conveyor, WhenFullReturnsTheOldestUnchangedAsTheNextDraft) {
  Conveyor<int, 2> conveyor;
  for (const int value : {1, 2}) {
    conveyor.Draft() = value;
    conveyor.Commit();
  }
  conveyor.Draft() = 3;
  int* const dropped = conveyor.Commit();
  CHECK(dropped != nullptr);
  LONGS_EQUAL(1, *dropped);
  POINTERS_EQUAL(dropped, &conveyor.Draft());
  LONGS_EQUAL(2, *conveyor.Pop());
  LONGS_EQUAL(3, *conveyor.Pop());
}

TEST(Conveyor, NeverRunsOutOfDraftsWhileTheConsumerHoldsAllItMay) {
  Conveyor<int, 4> conveyor;
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 3; ++i) {
      conveyor.Draft() = i;
      conveyor.Commit();
    }
    int* held[3];
    for (int*& slot : held) slot = conveyor.Pop();
    for (int i = 0; i < 10; ++i) {
      conveyor.Draft() = i;
      conveyor.Commit();
    }
    for (int i = 0; i < 3; ++i) LONGS_EQUAL(i, *held[i]);
    for (int* const slot : held) conveyor.GiveBack(slot);
    for (int newest = 6; newest < 10; ++newest) {
      int* const slot = conveyor.Pop();
      LONGS_EQUAL(newest, *slot);
      conveyor.GiveBack(slot);
    }
    POINTERS_EQUAL(nullptr, conveyor.Pop());
  }
}

TEST(Conveyor, AcrossThreadsEveryRecordArrivesWholeAndAscendingOrIsReportedDropped) {
  struct Record {
    std::uint64_t number = 0, copy = 0;
  };
  constexpr std::uint64_t kRecords = 200'000;
  Conveyor<Record, 4> conveyor;
  std::uint64_t dropped = 0;
  std::thread producer([&] {
    for (std::uint64_t n = 1; n <= kRecords; ++n) {
      conveyor.Draft() = {n, n};
      if (conveyor.Commit() != nullptr) ++dropped;
    }
  });
  std::uint64_t received = 0, last = 0;
  bool whole = true, ascending = true;
  while (last != kRecords) {
    Record* const record = conveyor.Pop();
    if (record == nullptr) continue;
    whole = whole && record->number == record->copy;
    ascending = ascending && record->number > last;
    last = record->number;
    ++received;
    conveyor.GiveBack(record);
  }
  producer.join();
  CHECK(whole);
  CHECK(ascending);
  CHECK_EQUAL(kRecords, received + dropped);
}
