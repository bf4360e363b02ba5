#include "firmware/capture/pairer.h"

#include <vector>

#include "tests/support/allocation_guard.h"

#include <CppUTest/TestHarness.h>

using adit::base::FrameStamp;
using adit::base::kNever;
using adit::base::kNsPerMs;
using adit::base::Side;
using adit::base::TimeNs;
using adit::capture::Pairer;
using adit::capture::PairerOptions;

namespace {

constexpr TimeNs kPeriodNs = 16'666'667;
constexpr TimeNs kStartNs = 1'700'000'000'000'000'000;

TimeNs TriggerNs(int trigger) { return kStartNs + trigger * kPeriodNs; }

/// What came out: pairs of handles, and handles without partner.
struct Outcome {
  std::vector<std::pair<int, int>> pairs;
  std::vector<int> left, right;
};

/// Feeds a pairer; a handle is the number of its trigger.
struct Feeder {
  Pairer<int> pairer{PairerOptions{}};
  Outcome out;
  TimeNs clock_error_ns[2] = {0, 0};
  TimeNs delay_ns[2] = {5 * kNsPerMs, 6 * kNsPerMs};

  void Frame(Side side, int trigger) {
    const std::size_t s = side == Side::kLeft ? 0 : 1;
    FrameStamp stamp;
    stamp.side = side;
    stamp.mid_exposure_ns = TriggerNs(trigger) + clock_error_ns[s];
    stamp.last_packet_ns = TriggerNs(trigger) + delay_ns[s];
    stamp.trigger = static_cast<std::uint64_t>(trigger);
    pairer.Add(stamp, trigger);
    Drain(stamp.last_packet_ns);
  }
  void Both(int trigger) {
    Frame(Side::kLeft, trigger);
    Frame(Side::kRight, trigger);
  }
  void Drain(TimeNs now_ns) {
    while (const auto event = pairer.Next(now_ns)) Note(*event);
  }
  void Note(const adit::capture::PairerEvent<int>& event) {
    if (event.Paired()) {
      out.pairs.emplace_back(*event.left, *event.right);
    } else if (event.left) {
      out.left.push_back(*event.left);
    } else {
      out.right.push_back(*event.right);
    }
  }
  void CheckEveryPairIsOfOneTrigger() const {
    for (const auto& [left, right] : out.pairs) LONGS_EQUAL(left, right);
  }
};

}  // namespace

TEST_GROUP(Pairer) { Feeder feeder; };

TEST(Pairer, PairsFramesOfOneTriggerWhicheverComesFirst) {
  feeder.Frame(Side::kLeft, 0);
  feeder.Frame(Side::kRight, 0);
  feeder.Frame(Side::kRight, 1);
  feeder.Frame(Side::kLeft, 1);
  LONGS_EQUAL(2, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
  LONGS_EQUAL(2, feeder.pairer.Counts().paired);
}

TEST(Pairer, PairsFramesOfWhichOneIsSeveralPeriodsLate) {
  for (int t = 0; t < 4; ++t) feeder.Frame(Side::kLeft, t);
  for (int t = 0; t < 4; ++t) feeder.Frame(Side::kRight, t);
  LONGS_EQUAL(4, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
}

TEST(Pairer, LosesOnePairForOneLostFrame) {
  for (int t = 0; t < 100; ++t) {
    if (t != 40) feeder.Frame(Side::kLeft, t);
    if (t != 70) feeder.Frame(Side::kRight, t);
  }
  LONGS_EQUAL(98, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
  LONGS_EQUAL(1, feeder.out.left.size());
  LONGS_EQUAL(70, feeder.out.left[0]);
  LONGS_EQUAL(1, feeder.out.right.size());
  LONGS_EQUAL(40, feeder.out.right[0]);
  LONGS_EQUAL(1, feeder.pairer.Counts().unpaired[0]);
  LONGS_EQUAL(1, feeder.pairer.Counts().unpaired[1]);
}

TEST(Pairer, CaresNothingForFrameCountsThatWrapSkipOrDiffer) {
  Pairer<int> pairer{PairerOptions{}};
  int pairs = 0;
  for (int t = 0; t < 50; ++t) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      FrameStamp stamp;
      stamp.side = side;
      stamp.mid_exposure_ns = TriggerNs(t);
      stamp.trigger =
          side == Side::kLeft ? (65530U + static_cast<unsigned>(t)) % 65536U : 7U * static_cast<unsigned>(t);
      pairer.Add(stamp, t);
      while (const auto event = pairer.Next(kNever)) pairs += event->Paired() ? 1 : 0;
    }
  }
  LONGS_EQUAL(50, pairs);
}

TEST(Pairer, ToleratesAQuarterOfThePeriodAndNoMore) {
  feeder.clock_error_ns[1] = kPeriodNs / 4 - 1;
  feeder.Both(0);
  LONGS_EQUAL(1, feeder.out.pairs.size());
  feeder.clock_error_ns[1] = kPeriodNs / 4 + 2;
  feeder.Both(1);
  feeder.Both(2);
  LONGS_EQUAL(1, feeder.out.pairs.size());
}

TEST(Pairer, GivesBackFramesOfACameraWhosePartnerIsSilent) {
  feeder.Both(0);
  for (int t = 1; t < 200; ++t) feeder.Frame(Side::kLeft, t);
  // At most five periods wait: the patience is 80 ms.
  CHECK(feeder.out.left.size() >= 199 - 6);
  feeder.Drain(TriggerNs(230));
  LONGS_EQUAL(199, feeder.out.left.size());
  feeder.Both(231);
  LONGS_EQUAL(2, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
}

TEST(Pairer, KeepsAFrameWhosePartnerMayStillCome) {
  feeder.Frame(Side::kLeft, 0);
  feeder.Drain(TriggerNs(0) + 84 * kNsPerMs);  // complete at 5 ms, patience 80 ms
  LONGS_EQUAL(0, feeder.out.left.size());
  feeder.Drain(TriggerNs(0) + 86 * kNsPerMs);
  LONGS_EQUAL(1, feeder.out.left.size());
}

TEST(Pairer, NeverHoldsMoreThanItCanWhenTimeStandsStill) {
  Pairer<int> pairer{PairerOptions{}};
  int given_back = 0;
  for (int t = 0; t < 1000; ++t) {
    FrameStamp stamp;
    stamp.mid_exposure_ns = TriggerNs(t);
    pairer.Add(stamp, t);
    while (const auto event = pairer.Next(kNever)) ++given_back;
  }
  CHECK(given_back >= 1000 - static_cast<int>(Pairer<int>::kWaitingMax));
  while (pairer.Flush()) ++given_back;
  LONGS_EQUAL(1000, given_back);
}

TEST(Pairer, MakesNoPairWhileOneClockIsSetAheadAndRecoversWithIt) {
  for (int t = 0; t < 10; ++t) feeder.Both(t);
  feeder.clock_error_ns[1] = 3600 * adit::base::kNsPerS;
  for (int t = 10; t < 40; ++t) feeder.Both(t);
  LONGS_EQUAL(10, feeder.out.pairs.size());
  CHECK(feeder.pairer.Counts().out_of_step > 10);
  feeder.clock_error_ns[1] = 0;
  for (int t = 40; t < 60; ++t) feeder.Both(t);
  // The first left frame meets a right one that is still dated ahead: one pair more is lost.
  LONGS_EQUAL(29, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
  LONGS_EQUAL(1, feeder.pairer.Counts().backwards[1]);
  LONGS_EQUAL(31, feeder.out.left.size());
  LONGS_EQUAL(31, feeder.out.right.size());
}

TEST(Pairer, MakesNoPairWhileOneClockIsSetBackAndRecoversWithIt) {
  for (int t = 0; t < 10; ++t) feeder.Both(t);
  feeder.clock_error_ns[0] = -10 * adit::base::kNsPerS;
  for (int t = 10; t < 40; ++t) feeder.Both(t);
  LONGS_EQUAL(10, feeder.out.pairs.size());
  LONGS_EQUAL(1, feeder.pairer.Counts().backwards[0]);
  feeder.clock_error_ns[0] = 0;
  for (int t = 40; t < 60; ++t) feeder.Both(t);
  LONGS_EQUAL(30, feeder.out.pairs.size());
  feeder.CheckEveryPairIsOfOneTrigger();
}

TEST(Pairer, SurvivesTimesAtTheEndsOfTheirRange) {
  Pairer<int> pairer{PairerOptions{}};
  FrameStamp stamp;
  stamp.mid_exposure_ns = INT64_MAX;
  pairer.Add(stamp, 1);
  stamp.side = Side::kRight;
  stamp.mid_exposure_ns = INT64_MIN + 1;
  pairer.Add(stamp, 2);
  int events = 0;
  while (const auto event = pairer.Next(0)) {
    ++events;
    CHECK_FALSE(event->Paired());
  }
  while (pairer.Flush()) ++events;
  LONGS_EQUAL(2, events);
}

TEST(Pairer, AccountsForEveryFrameOfALossyStream) {
  std::uint32_t random = 12345;  // a linear congruential generator's seed
  const auto lost = [&random](int percent) {
    random = random * 1664525U + 1013904223U;
    return random >> 16 < static_cast<std::uint32_t>(percent) * 65536U / 100U;
  };
  std::size_t sent[2] = {0, 0}, both = 0;
  for (int t = 0; t < 5000; ++t) {
    const bool left = !lost(10), right = !lost(5);
    if (left) feeder.Frame(Side::kLeft, t), ++sent[0];
    if (right) feeder.Frame(Side::kRight, t), ++sent[1];
    both += left && right ? 1U : 0U;
  }
  while (const auto event = feeder.pairer.Flush()) feeder.Note(*event);
  LONGS_EQUAL(both, feeder.out.pairs.size());
  LONGS_EQUAL(sent[0], feeder.out.pairs.size() + feeder.out.left.size());
  LONGS_EQUAL(sent[1], feeder.out.pairs.size() + feeder.out.right.size());
  feeder.CheckEveryPairIsOfOneTrigger();
}

TEST(Pairer, AllocatesNothing) {
  if (!adit::support::CountsAllocations()) return;
  Pairer<int> pairer{PairerOptions{}};
  const auto before = adit::support::AllocationCount();
  for (int t = 0; t < 100; ++t) {
    FrameStamp stamp;
    stamp.mid_exposure_ns = TriggerNs(t);
    stamp.side = t % 3 == 0 ? Side::kRight : Side::kLeft;
    pairer.Add(stamp, t);
    while (pairer.Next(TriggerNs(t))) continue;
  }
  LONGS_EQUAL(before, adit::support::AllocationCount());
}
