// A vector that owns its storage: no heap, a capacity known at compile time.
#pragma once

#include <array>
#include <cstddef>

#include "firmware/base/require.h"

namespace adit::base {

/// Up to N values in place. push_back on a full vector declines and returns false: the caller counts what it
/// drops. T must be default constructible; elements beyond size() keep old values.
template <class T, std::size_t N>
class FixedVector {
 public:
  static constexpr std::size_t kCapacity = N;

  bool push_back(const T& value) {
    if (size_ == N) return false;
    items_[size_++] = value;
    return true;
  }
  void clear() { size_ = 0; }
  /// Shortens to `size` elements; `size` must not exceed the present size.
  void Truncate(std::size_t size) {
    ADIT_REQUIRE(size <= size_);
    size_ = size;
  }
  bool Full() const { return size_ == N; }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }

  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  T& back() { return items_[size_ - 1]; }
  const T& back() const { return items_[size_ - 1]; }
  T* data() { return items_.data(); }
  const T* data() const { return items_.data(); }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

}  // namespace adit::base
