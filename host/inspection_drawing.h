// An inspection as a picture for a service engineer.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "host/inspection.h"

namespace adit::host {

/// What is drawn beside the inspection.
struct DrawingOrder {
  const optics::Rig* rig = nullptr;
  std::vector<std::string> names;  ///< of the targets, in model order
  std::string title;
};

/// Both images side by side, brightened, and below them a row of each target, enlarged, with what became of
/// it, the candidates with their verdicts, and a legend. Coloured circles with a number are LEDs, lines the
/// candidates, thin lines in the right image the epipolar lines of the candidates' LEDs; grey circles are
/// blobs of no target, red crosses bright things that cannot be LEDs. 8 bit BGR.
cv::Mat DrawInspection(const ImagePair& pair, const Inspection& inspection, const DrawingOrder& order);

}  // namespace adit::host
