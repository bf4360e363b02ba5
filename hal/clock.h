// The box clock.
#pragma once

#include "firmware/base/time.h"

namespace adit::hal {

/// One clock for everything that is dated. Callable from any thread; never blocks.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual base::TimeNs Now() const = 0;
};

}  // namespace adit::hal
