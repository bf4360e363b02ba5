// What a person sees during the demo.
#pragma once

#include <string>

#include "host/demo_stage.h"

namespace adit::host {

/// What the view shows of one target, as a machine believes it.
struct ShownTarget {
  std::string name;
  bool good = false;
  std::array<double, 3> position_m{};
};

/// One picture of the state for a terminal: a plan of the tunnel, positions, rates, latencies, counters.
/// Lines end in
/// "\n"; `colour` adds ANSI colours.
std::string DrawDemo(DemoStage& stage, double elapsed_s, double total_s, bool colour);

/// The same as one plain line, for a pipe.
std::string DemoLine(DemoStage& stage, double elapsed_s);

}  // namespace adit::host
