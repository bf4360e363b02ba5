// A value, or the one line that says why there is none. For boundaries (files, devices, command lines); the
// hot path declines with a status instead.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "firmware/base/require.h"

namespace adit::base {

enum class ErrorCode {
  kUsage,        ///< the caller asked for something that does not exist: exit code 2
  kMalformed,    ///< a file or message is not of its format: exit code 2
  kOutOfRange,   ///< a value is outside what is permitted: exit code 2
  kNotFound,     ///< a file or device is not there: exit code 1
  kUnavailable,  ///< it is there and does not serve: exit code 1
  kFailed,       ///< the work itself failed: exit code 1
};

struct Error {
  ErrorCode code = ErrorCode::kFailed;
  std::string where;   ///< file and key, or device
  std::string detail;  ///< what is wrong, the value, and what is allowed

  /// "where: detail", one line.
  std::string Line() const { return where.empty() ? detail : where + ": " + detail; }

  /// The process exit code: 2 for wrong use or wrong input, 1 for work that failed.
  int ExitCode() const {
    return code == ErrorCode::kUsage || code == ErrorCode::kMalformed || code == ErrorCode::kOutOfRange ? 2
                                                                                                        : 1;
  }
};

/// Either a T or an Error. Test it before use: value() of an error, or error() of a value, is a bug and
/// aborts.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return content_.index() == 0; }
  T& value() & {
    ADIT_REQUIRE(*this);
    return *std::get_if<0>(&content_);
  }
  const T& value() const& {
    ADIT_REQUIRE(*this);
    return *std::get_if<0>(&content_);
  }
  T&& value() && {
    ADIT_REQUIRE(*this);
    return std::move(*std::get_if<0>(&content_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const {
    ADIT_REQUIRE(!*this);
    return *std::get_if<1>(&content_);
  }

 private:
  std::variant<T, Error> content_;
};

/// Done, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  explicit operator bool() const { return !error_.has_value(); }
  const Error& error() const {
    ADIT_REQUIRE(error_.has_value());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace adit::base
