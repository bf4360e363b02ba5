// The exploration itself, on the classic litmus tests, whose answers the C++ standard and the literature
// give (names as in Alglave et al., "Herding cats", TOPLAS 2014).
#include "tests/support/interleavings.h"

#include <memory>

#include <CppUTest/TestHarness.h>

using adit::support::CanExplore;
using adit::support::Exploration;
using adit::support::Explore;
using adit::support::ModelAtomic;
using adit::support::ModelOwned;
using adit::support::Scenario;

namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;
constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;

/// Message passing: data, then a flag; whoever sees the flag must see the data.
Exploration MessagePassing(std::memory_order store, std::memory_order load) {
  return Explore([=] {
    struct State {
      ModelAtomic<int> data, flag;
      int seen_flag = 0, seen_data = 0;
    };
    auto state = std::make_shared<State>();
    return Scenario{{[=] {
                       state->data.store(1, kRelaxed);
                       state->flag.store(1, store);
                     },
                     [=] {
                       state->seen_flag = state->flag.load(load);
                       state->seen_data = state->data.load(kRelaxed);
                     }},
                    [=] { return state->seen_flag == 0 || state->seen_data == 1; }};
  });
}

/// Plain memory behind the flag.
Exploration Ownership(std::memory_order store, std::memory_order load) {
  return Explore([=] {
    struct State {
      ModelOwned memory;
      ModelAtomic<int> flag;
    };
    auto state = std::make_shared<State>();
    return Scenario{{[=] {
                       state->memory.Touch();
                       state->flag.store(1, store);
                     },
                     [=] {
                       if (state->flag.load(load) == 1) state->memory.Touch();
                     }},
                    [] { return true; }};
  });
}

}  // namespace

TEST_GROUP(Interleavings){};

TEST(Interleavings, FindThatRelaxedMessagesArriveBeforeTheirData) {
  if (!CanExplore()) return;
  CHECK_TRUE(MessagePassing(kRelaxed, kRelaxed).failures > 0);
  CHECK_TRUE(MessagePassing(kRelease, kRelaxed).failures > 0);
  CHECK_TRUE(MessagePassing(kRelaxed, kAcquire).failures > 0);
}

TEST(Interleavings, FindNothingWrongWithReleaseAndAcquire) {
  if (!CanExplore()) return;
  const Exploration exploration = MessagePassing(kRelease, kAcquire);
  LONGS_EQUAL(0, exploration.failures);
  LONGS_EQUAL(3, exploration.executions);  // no flag with old or new data, flag with data
}

TEST(Interleavings, FindRacesOnPlainMemory) {
  if (!CanExplore()) return;
  LONGS_EQUAL(0, Ownership(kRelease, kAcquire).failures);
  CHECK_TRUE(Ownership(kRelaxed, kAcquire).failures > 0);
  CHECK_TRUE(Ownership(kRelease, kRelaxed).failures > 0);
}

TEST(Interleavings, FindThatStoreBufferingIsNotSequential) {
  if (!CanExplore()) return;
  // SB: with release and acquire both may read 0; only sequential consistency forbids it.
  const Exploration exploration = Explore([] {
    struct State {
      ModelAtomic<int> x, y;
      int seen_x = 0, seen_y = 0;
    };
    auto state = std::make_shared<State>();
    return Scenario{{[=] {
                       state->x.store(1, kRelease);
                       state->seen_y = state->y.load(kAcquire);
                     },
                     [=] {
                       state->y.store(1, kRelease);
                       state->seen_x = state->x.load(kAcquire);
                     }},
                    [=] { return state->seen_x + state->seen_y > 0; }};
  });
  CHECK_TRUE(exploration.failures > 0);
}

TEST(Interleavings, KeepReadsOfOneLocationInOrder) {
  if (!CanExplore()) return;
  // CoRR: even relaxed, a later read does not see an older store.
  const Exploration exploration = Explore([] {
    struct State {
      ModelAtomic<int> x;
      int first = 0, second = 0;
    };
    auto state = std::make_shared<State>();
    return Scenario{{[=] {
                       state->x.store(1, kRelaxed);
                       state->x.store(2, kRelaxed);
                     },
                     [=] {
                       state->first = state->x.load(kRelaxed);
                       state->second = state->x.load(kRelaxed);
                     }},
                    [=] { return state->first <= state->second; }};
  });
  LONGS_EQUAL(0, exploration.failures);
}

TEST(Interleavings, LetOnlyOneOfTwoCompareExchangesWin) {
  if (!CanExplore()) return;
  const Exploration exploration = Explore([] {
    struct State {
      ModelAtomic<int> x;
      int wins = 0;
    };
    auto state = std::make_shared<State>();
    const auto attempt = [=] {
      int expected = 0;
      if (state->x.compare_exchange_strong(expected, 1, kRelaxed, kRelaxed)) ++state->wins;
    };
    return Scenario{{attempt, attempt}, [=] { return state->wins == 1; }};
  });
  LONGS_EQUAL(0, exploration.failures);
  LONGS_EQUAL(0, exploration.cut_short);
}

TEST(Interleavings, CutShortALoopThatWaitsForEver) {
  if (!CanExplore()) return;
  const Exploration exploration = Explore(
      [] {
        auto never = std::make_shared<ModelAtomic<int>>();
        return Scenario{{[=] {
                          while (never->load(kRelaxed) == 0) {
                          }
                        }},
                        [] { return true; }};
      },
      20);
  LONGS_EQUAL(0, exploration.executions);
  LONGS_EQUAL(1, exploration.cut_short);
}
