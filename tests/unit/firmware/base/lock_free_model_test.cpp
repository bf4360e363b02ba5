// The ring, the conveyor and the latest value in every order of steps that the C++ memory model allows: up to
// four pushes against two pops, two stores against a load. x86 shows few of them; an ARM box shows them all.
// Weakening an order of Push, Pop, Store or Load makes a test here fail, except those that keep the
// consumer's read of a slot before its reuse (release in Pop, acquires of read_ in Push): the model's loads
// are never that late.
#include <array>
#include <memory>
#include <vector>

#include "firmware/base/conveyor.h"
#include "firmware/base/latest.h"
#include "firmware/base/ring.h"
#include "tests/support/interleavings.h"

#include <CppUTest/TestHarness.h>

using adit::base::Conveyor;
using adit::base::DropOldestRing;
using adit::base::Latest;
using adit::support::CanExplore;
using adit::support::Exploration;
using adit::support::Explore;
using adit::support::ModelAtomic;
using adit::support::ModelOwned;
using adit::support::Scenario;

namespace {

constexpr std::size_t kPlaces = 2;

/// Items are numbers of buffers, which their owner touches: before a push, after a pop, after a drop.
struct RingState {
  DropOldestRing<std::uint32_t, kPlaces, ModelAtomic> ring;
  std::array<ModelOwned, 6> buffers;
  std::vector<std::uint32_t> dropped, popped;

  void Push(std::uint32_t item) {
    buffers[item].Touch();
    if (const auto oldest = ring.Push(item)) {
      buffers[*oldest].Touch();
      dropped.push_back(*oldest);
    }
  }
  void Pop() {
    if (const auto item = ring.Pop()) {
      buffers[*item].Touch();
      popped.push_back(*item);
    }
  }
  /// Each of `pushed` items is in exactly one of: dropped, popped, still there; each list in order.
  bool EachOnceAndInOrder(std::size_t pushed) {
    while (const auto item = ring.Pop()) popped.push_back(*item);
    std::vector<int> times(pushed, 0);
    for (const auto* list : {&dropped, &popped}) {
      for (std::size_t i = 0; i < list->size(); ++i) {
        if (i > 0 && (*list)[i] <= (*list)[i - 1]) return false;
        if ((*list)[i] >= pushed) return false;
        ++times[(*list)[i]];
      }
    }
    for (const int count : times) {
      if (count != 1) return false;
    }
    return true;
  }
};

/// `before` pushes fill the ring, then `during` pushes meet `pops`.
Exploration ExploreRing(std::uint32_t before, std::uint32_t during, int pops) {
  return Explore([=] {
    auto state = std::make_shared<RingState>();
    for (std::uint32_t i = 0; i < before; ++i) state->Push(i);
    return Scenario{{[=] {
                       for (std::uint32_t i = 0; i < during; ++i) state->Push(before + i);
                     },
                     [=] {
                       for (int i = 0; i < pops; ++i) state->Pop();
                     }},
                    [=] { return state->EachOnceAndInOrder(before + during); }};
  });
}

}  // namespace

TEST_GROUP(LockFreeModel){};

TEST(LockFreeModel, RingHandsOverEachItemOnceWhenItFillsUp) {
  if (!CanExplore()) return;
  const Exploration exploration = ExploreRing(0, 4, 2);
  LONGS_EQUAL(0, exploration.failures);
  LONGS_EQUAL(0, exploration.cut_short);
  CHECK_TRUE(exploration.executions > 0);
}

TEST(LockFreeModel, RingHandsOverEachItemOnceWhenBothTakeTheOldest) {
  if (!CanExplore()) return;
  const Exploration exploration = ExploreRing(2, 3, 2);
  LONGS_EQUAL(0, exploration.failures);
  LONGS_EQUAL(0, exploration.cut_short);
  CHECK_TRUE(exploration.executions > 0);
}

// A record is its producer's from Draft to Commit and its consumer's from Pop to GiveBack. The conveyor is
// full when the two begin, so that both take the oldest, and a slot goes round.
TEST(LockFreeModel, ConveyorLeavesEachRecordToOneThreadAtATime) {
  if (!CanExplore()) return;
  struct State {
    Conveyor<ModelOwned, kPlaces, ModelAtomic> conveyor;
    int committed = 0, dropped = 0, popped = 0;
    void Commit() {
      conveyor.Draft().Touch();
      if (ModelOwned* const oldest = conveyor.Commit()) oldest->Touch(), ++dropped;
      ++committed;
    }
    bool Pop() {
      ModelOwned* const record = conveyor.Pop();
      if (record == nullptr) return false;
      record->Touch();
      conveyor.GiveBack(record);
      return ++popped > 0;
    }
  };
  const Exploration exploration = Explore([] {
    auto state = std::make_shared<State>();
    for (std::size_t i = 0; i < kPlaces; ++i) state->Commit();
    return Scenario{{[=] {
                       for (int i = 0; i < 2; ++i) state->Commit();
                     },
                     [=] {
                       state->Pop();
                       state->Pop();
                     }},
                    [=] {
                      while (state->Pop()) {
                      }
                      return state->committed == state->dropped + state->popped;
                    }};
  });
  LONGS_EQUAL(0, exploration.failures);
  LONGS_EQUAL(0, exploration.cut_short);
  CHECK_TRUE(exploration.executions > 1);
}

TEST(LockFreeModel, LatestIsNeverTorn) {
  if (!CanExplore()) return;
  struct Pair {
    std::uint64_t first = 0, second = 0;
  };
  struct State {
    Latest<Pair, ModelAtomic> latest;
    Pair seen;
    std::uint64_t stores = 0;
  };
  constexpr int kMostSteps = 20;  // 8 of the writer, 4 of a load, and two loads again that met a store
  const Exploration exploration = Explore(
      [] {
        auto state = std::make_shared<State>();
        return Scenario{{[=] {
                           state->latest.Store({1, 101});
                           state->latest.Store({2, 102});
                         },
                         [=] { state->seen = state->latest.Load(&state->stores); }},
                        [=] {
                          return state->seen.first == state->stores &&
                                 state->seen.second == (state->stores == 0 ? 0 : state->stores + 100);
                        }};
      },
      kMostSteps);
  LONGS_EQUAL(0, exploration.failures);
  CHECK_TRUE(exploration.executions > 0);
}
