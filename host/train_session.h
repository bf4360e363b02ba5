// Training from geometry and recordings, with or without the proposed mends.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/train_report.h"

namespace adit::host {

struct TrainOrder {
  base::Target target;
  std::string target_file, camera;  ///< for messages; sensor.yaml of all cameras, or empty
  TrainingOptions options;
  Eigen::Vector2i size_px{1400, 1024};  ///< of the images
  std::vector<std::string> recordings;
  std::vector<base::TimeNs> discarded;  ///< mid-exposure times of images to leave out
  std::vector<identify::Model> others;
  bool apply = false;  ///< take over the mends that are proposed
};

/// Declines when a recording cannot be read, a discarded time is in none, or no image shows the target
/// exactly once.
base::Result<Training> Train(const TrainOrder& order);

/// Applies what a review proposes to `model`: values that let a missed target in without another match, then
/// those that cut a second match off; images that no value mends are left out. Again while that changes
/// anything. What was done is appended to `training.applied`.
void ApplyMends(const TrainOrder& order, Training& training);

}  // namespace adit::host
