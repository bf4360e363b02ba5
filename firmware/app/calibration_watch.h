// The watch over the calibration, between the thread that feeds it and those that ask.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/latest.h"
#include "firmware/base/target.h"
#include "firmware/publish/health_report.h"
#include "firmware/watch/watch.h"

namespace adit::app {

/// Add belongs to the pairing thread, Latest to any.
class CalibrationWatch {
 public:
  CalibrationWatch(const optics::Rig& rig, const std::vector<base::Target>& targets,
                   const watch::WatchOptions& options, const watch::MotionMatrix& covariance)
      : watch_(rig, targets, options, covariance) {}

  void Add(const stereo::PointSet& points) {
    watch_.Add(points);
    latest_.Store(watch_.Latest());
  }
  watch::Finding Latest() const { return latest_.Load(); }

 private:
  watch::Watch watch_;
  base::Latest<watch::Finding> latest_;
};

/// One line of `key=value` words: `watch verdict=holds tracked_s=412 ...`; angles in microradians, pitch,
/// yaw, roll.
std::string FormatFinding(const watch::Finding& finding);

/// The same for the health report.
publish::CalibrationHealth HealthOf(const watch::Finding& finding, const std::string& calibration_id);

/// What the operator is told when a calibration does not hold: the turn, and the command that applies it.
std::string FormatAdvice(const watch::Finding& finding, const std::string& rig_path);

}  // namespace adit::app
