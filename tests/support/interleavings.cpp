#include "tests/support/interleavings.h"

#include <ucontext.h>

#include <algorithm>
#include <array>
#include <memory>

#include "firmware/base/require.h"

namespace adit::support {
namespace {

constexpr std::size_t kMostLocations = 24;
constexpr std::size_t kMostThreads = 8;
constexpr std::size_t kStackBytes = 256 * 1024;

/// For each location, the oldest store that may still be read.
struct View {
  std::array<int, kMostLocations> oldest{};

  void Join(const View& other) {
    for (std::size_t i = 0; i < oldest.size(); ++i) oldest[i] = std::max(oldest[i], other.oldest[i]);
  }
};

struct StoreRecord {
  std::uint64_t value = 0;
  View published;  ///< what an acquire that reads this store learns
};

/// What a thread will do next.
struct Step {
  int location = 0;
  bool writes = false;
};

struct Fiber {
  ucontext_t context{};
  Step next;
  std::vector<char> stack = std::vector<char>(kStackBytes);
  std::function<void()> work;
  View view;
  bool ended = false;
};

bool Acquires(std::memory_order order) {
  ADIT_REQUIRE(order != std::memory_order_seq_cst && order != std::memory_order_consume);
  return order == std::memory_order_acquire || order == std::memory_order_acq_rel;
}

bool Releases(std::memory_order order) {
  ADIT_REQUIRE(order != std::memory_order_seq_cst);
  return order == std::memory_order_release || order == std::memory_order_acq_rel;
}

/// One execution after the other; a path of choices says which.
class World {
 public:
  Exploration Run(const std::function<Scenario()>& make, int most_steps);

  int MakeLocation(std::uint64_t value) {
    ADIT_REQUIRE(locations_.size() < kMostLocations);
    locations_.push_back({{value, {}}});
    return static_cast<int>(locations_.size()) - 1;
  }

  std::uint64_t Load(int location, std::memory_order order) {
    Before({location, false});
    const auto& stores = At(location);
    int& oldest = Now().oldest[static_cast<std::size_t>(location)];
    oldest += Choose(static_cast<int>(stores.size()) - oldest);
    const StoreRecord& read = stores[static_cast<std::size_t>(oldest)];
    if (Acquires(order)) Now().Join(read.published);
    return read.value;
  }

  void Store(int location, std::uint64_t value, std::memory_order order) {
    Before({location, true});
    Append(location, value, order, {});
  }

  std::uint64_t Exchange(int location, std::uint64_t value, std::memory_order order) {
    Before({location, true});
    return ReplaceLast(location, value, order);
  }

  bool CompareExchange(int location, model::Exchanging& wish) {
    Before({location, true});
    // It succeeds on the last store only, and may fail on any that differs and is not too old for this
    // thread.
    const auto& stores = At(location);
    const int oldest = Now().oldest[static_cast<std::size_t>(location)];
    const int last = static_cast<int>(stores.size()) - 1;
    std::vector<int> readable;
    for (int i = oldest; i <= last; ++i) {
      if (stores[static_cast<std::size_t>(i)].value != wish.expected) readable.push_back(i);
    }
    const bool can_succeed = stores.back().value == wish.expected;
    const int choice = Choose(static_cast<int>(readable.size()) + (can_succeed ? 1 : 0));
    if (can_succeed && choice == static_cast<int>(readable.size())) {
      ReplaceLast(location, wish.desired, wish.success);
      return true;
    }
    const int index = readable[static_cast<std::size_t>(choice)];
    Now().oldest[static_cast<std::size_t>(location)] = index;
    wish.expected = stores[static_cast<std::size_t>(index)].value;
    if (Acquires(wish.failure)) Now().Join(stores[static_cast<std::size_t>(index)].published);
    return false;
  }

  void Own(int location) {
    const auto& stores = At(location);
    if (Now().oldest[static_cast<std::size_t>(location)] + 1 != static_cast<int>(stores.size()))
      raced_ = true;
    Append(location, 0, std::memory_order_relaxed, {});
  }

  void RunFiber() {
    fibers_[current_]->work();
    fibers_[current_]->ended = true;
    SwitchToScheduler();
  }

 private:
  std::vector<StoreRecord>& At(int location) { return locations_[static_cast<std::size_t>(location)]; }
  View& Now() { return inside_ ? fibers_[current_]->view : outside_; }

  /// Before each step of a thread, any other may come first.
  void Before(Step step) {
    if (!inside_) return;
    fibers_[current_]->next = step;
    SwitchToScheduler();
  }
  void Resume() {
    inside_ = true;
    swapcontext(&scheduler_, &fibers_[current_]->context);
    inside_ = false;
  }
  void SwitchToScheduler() { swapcontext(&fibers_[current_]->context, &scheduler_); }

  /// The next of `count` possibilities at this point of the path. Outside the threads the last store counts.
  int Choose(int count) {
    ADIT_REQUIRE(count > 0);
    if (!inside_ && !scheduling_) return count - 1;
    if (count == 1) return 0;
    if (depth_ == path_.size()) path_.push_back({0, count});
    ADIT_REQUIRE(path_[depth_].count == count);  // the scenario is not deterministic
    return path_[depth_++].taken;
  }

  void Append(int location, std::uint64_t value, std::memory_order order, const View& inherited) {
    auto& stores = At(location);
    Now().oldest[static_cast<std::size_t>(location)] = static_cast<int>(stores.size());
    StoreRecord record{value, inherited};
    if (Releases(order)) record.published.Join(Now());
    stores.push_back(record);
  }

  /// A read-modify-write: reads the last store and continues its release sequence.
  std::uint64_t ReplaceLast(int location, std::uint64_t value, std::memory_order order) {
    const StoreRecord read = At(location).back();
    if (Acquires(order)) Now().Join(read.published);
    Append(location, value, order, read.published);
    return read.value;
  }

  void Start(const Scenario& scenario);
  enum class Outcome { kEnded, kCutShort, kCovered };
  Outcome RunToEnd(int most_steps);
  bool NextPath();

  struct Choice {
    int taken, count;
  };
  std::vector<Choice> path_;
  std::size_t depth_ = 0;
  std::vector<std::vector<StoreRecord>> locations_;
  std::vector<std::unique_ptr<Fiber>> fibers_;
  std::size_t current_ = 0;
  View outside_;
  ucontext_t scheduler_{};
  bool inside_ = false, scheduling_ = false, raced_ = false;
};

World* world = nullptr;

void FiberMain() { world->RunFiber(); }

void World::Start(const Scenario& scenario) {
  while (fibers_.size() < scenario.threads.size()) fibers_.push_back(std::make_unique<Fiber>());
  for (std::size_t i = 0; i < fibers_.size(); ++i) {
    Fiber& fiber = *fibers_[i];
    fiber.work = scenario.threads[i];
    fiber.view = outside_;
    fiber.ended = false;
    getcontext(&fiber.context);
    fiber.context.uc_stack.ss_sp = fiber.stack.data();
    fiber.context.uc_stack.ss_size = fiber.stack.size();
    fiber.context.uc_link = nullptr;
    makecontext(&fiber.context, FiberMain, 0);
  }
  // What stands before a thread's first step touches nothing shared: no order of it to try.
  for (current_ = 0; current_ < fibers_.size(); ++current_) Resume();
}

/// Sleep sets (Godefroid, "Partial-order methods for the verification of concurrent systems", 1996): a thread
/// whose step was tried first at an earlier point sleeps until a step that could change its outcome. Steps on
/// different locations do not; and a load before a step on its location gives nothing that the same load
/// after it does not, for it may still return the older store. So writes are tried first.
World::Outcome World::RunToEnd(int most_steps) {
  std::uint32_t sleeping = 0;
  for (int step = 0;; ++step) {
    std::array<std::size_t, kMostThreads> awake{};
    int count = 0, running = 0;
    for (const bool writes : {true, false}) {
      for (std::size_t i = 0; i < fibers_.size(); ++i) {
        if (fibers_[i]->ended || fibers_[i]->next.writes != writes) continue;
        ++running;
        if ((sleeping & (1U << i)) == 0) awake[static_cast<std::size_t>(count++)] = i;
      }
    }
    if (running == 0) return Outcome::kEnded;
    if (count == 0) return Outcome::kCovered;
    if (step == most_steps) return Outcome::kCutShort;
    scheduling_ = true;
    const auto taken = static_cast<std::size_t>(Choose(count));
    scheduling_ = false;
    current_ = awake[taken];
    for (std::size_t i = 0; i < taken; ++i) sleeping |= 1U << awake[i];
    const Step chosen = fibers_[current_]->next;
    for (std::size_t i = 0; i < fibers_.size(); ++i) {
      if (chosen.writes && fibers_[i]->next.location == chosen.location) sleeping &= ~(1U << i);
    }
    Resume();
  }
}

/// Depth first: the last choice that has possibilities left takes the next one.
bool World::NextPath() {
  while (!path_.empty() && path_.back().taken + 1 == path_.back().count) path_.pop_back();
  if (path_.empty()) return false;
  ++path_.back().taken;
  return true;
}

Exploration World::Run(const std::function<Scenario()>& make, int most_steps) {
  Exploration exploration;
  do {
    depth_ = 0;
    locations_.clear();
    outside_ = {};
    raced_ = false;
    const Scenario scenario = make();
    Start(scenario);
    const Outcome outcome = RunToEnd(most_steps);
    exploration.executions += outcome == Outcome::kEnded ? 1 : 0;
    exploration.cut_short += outcome == Outcome::kCutShort ? 1 : 0;
    exploration.failures += raced_ || (outcome == Outcome::kEnded && !scenario.holds()) ? 1 : 0;
  } while (NextPath());
  return exploration;
}

}  // namespace

Exploration Explore(const std::function<Scenario()>& make, int most_steps) {
  World here;
  world = &here;
  const Exploration exploration = here.Run(make, most_steps);
  world = nullptr;
  return exploration;
}

bool CanExplore() {
#if defined(__SANITIZE_THREAD__)
  return false;
#else
  return true;
#endif
}

namespace model {

int MakeLocation(std::uint64_t value) { return world->MakeLocation(value); }
std::uint64_t Load(int location, std::memory_order order) { return world->Load(location, order); }
void Store(int location, std::uint64_t value, std::memory_order order) {
  world->Store(location, value, order);
}
std::uint64_t Exchange(int location, std::uint64_t value, std::memory_order order) {
  return world->Exchange(location, value, order);
}
bool CompareExchange(int location, Exchanging& exchanging) {
  return world->CompareExchange(location, exchanging);
}
void Own(int location) { world->Own(location); }

}  // namespace model
}  // namespace adit::support
