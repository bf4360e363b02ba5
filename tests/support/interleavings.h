// Small concurrent programs, run in every order of their steps, with every value that their memory orders let
// a load return: what a stress test meets by luck, and what x86 hides altogether.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace adit::support {

/// A program of a few threads over ModelAtomic and ModelOwned objects. `holds` is asked once all threads have
/// ended.
struct Scenario {
  std::vector<std::function<void()>> threads;
  std::function<bool()> holds;
};

struct Exploration {
  long executions =
      0;  ///< run to their end; those that differ only in the order of unrelated steps count once
  long cut_short = 0;  ///< given up after `most_steps`: a loop that waits for another thread
  long failures = 0;   ///< executions after which `holds` was false, or with a race on a ModelOwned
};

/// Runs what `make` returns once for each execution that the view semantics of C++'s release-acquire and
/// relaxed accesses allow (Kang et al., "A promising semantics for relaxed-memory concurrency", POPL 2017,
/// section 3, without promises: no load returns a store that its own thread has yet to allow). The
/// modification order of a location is its order of execution, which is exact where one thread writes plainly
/// or all write by read-modify-write. Deterministic: the orders are enumerated, not drawn. Not under
/// ThreadSanitizer, which does not follow its change of stacks.
Exploration Explore(const std::function<Scenario()>& make, int most_steps = 200);

/// Whether this build can run Explore.
bool CanExplore();

namespace model {

int MakeLocation(std::uint64_t value);
std::uint64_t Load(int location, std::memory_order order);
void Store(int location, std::uint64_t value, std::memory_order order);
std::uint64_t Exchange(int location, std::uint64_t value, std::memory_order order);

/// The arguments of a compare-exchange.
struct Exchanging {
  std::uint64_t expected, desired;
  std::memory_order success, failure;
};
/// Whether it succeeded; `expected` is what it read.
bool CompareExchange(int location, Exchanging& exchanging);
void Own(int location);

template <class T>
std::uint64_t ToWord(T value) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= sizeof(std::uint64_t));
  std::uint64_t word = 0;
  std::memcpy(&word, &value, sizeof value);
  return word;
}

template <class T>
T FromWord(std::uint64_t word) {
  T value;
  std::memcpy(&value, &word, sizeof value);
  return value;
}

}  // namespace model

/// Stands in for std::atomic inside Explore. No sequentially consistent order: nothing here needs one.
/// compare_exchange_weak never fails for no reason: that would only repeat its loop.
template <class T>
class ModelAtomic {
 public:
  // The names are the standard library's: it stands in its place.
  // NOLINTBEGIN(readability-identifier-naming)
  static constexpr bool is_always_lock_free = true;

  ModelAtomic() : ModelAtomic(T{}) {}
  ModelAtomic(T value) : location_(model::MakeLocation(model::ToWord(value))) {}
  ModelAtomic(const ModelAtomic&) = delete;
  ModelAtomic& operator=(const ModelAtomic&) = delete;

  T load(std::memory_order order) const { return model::FromWord<T>(model::Load(location_, order)); }
  void store(T value, std::memory_order order) { model::Store(location_, model::ToWord(value), order); }
  T exchange(T value, std::memory_order order) {
    return model::FromWord<T>(model::Exchange(location_, model::ToWord(value), order));
  }
  bool compare_exchange_strong(T& expected, T desired, std::memory_order success, std::memory_order failure) {
    model::Exchanging exchanging{model::ToWord(expected), model::ToWord(desired), success, failure};
    const bool done = model::CompareExchange(location_, exchanging);
    expected = model::FromWord<T>(exchanging.expected);
    return done;
  }
  bool compare_exchange_weak(T& expected, T desired, std::memory_order success, std::memory_order failure) {
    return compare_exchange_strong(expected, desired, success, failure);
  }
  // NOLINTEND(readability-identifier-naming)

 private:
  int location_;
};

/// Plain memory that has one owner at a time. Touch fails the execution unless all earlier touches happen
/// before it: it would be a data race.
class ModelOwned {
 public:
  ModelOwned() : location_(model::MakeLocation(0)) {}
  void Touch() { model::Own(location_); }

 private:
  int location_;
};

}  // namespace adit::support
