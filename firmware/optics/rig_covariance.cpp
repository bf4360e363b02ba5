#include "firmware/optics/rig_covariance.h"

#include <iomanip>
#include <sstream>

#include "firmware/base/yaml_pose.h"

namespace adit::optics {

base::Result<std::optional<RigCovariance>> LoadRigCovariance(const std::string& path) {
  auto in = base::YamlReader::OpenFile(path);
  if (!in) return in.error();
  std::optional<RigCovariance> covariance;
  if (in->Has("covariance")) base::ReadCovariance(*in, "covariance", covariance.emplace());
  // The rest is LoadRig's.
  for (const std::string& key : in->Keys()) in->Ignore(key);
  if (auto done = in->Finish(); !done) return done.error();
  return covariance;
}

std::string FormatRigCovariance(const RigCovariance& covariance) {
  std::ostringstream text;
  text << "covariance:  # of (rotation vector in cam1's frame: rad, translation: m)\n"
       << std::setprecision(9);
  for (Eigen::Index r = 0; r < covariance.rows(); ++r) {
    text << "  - [";
    for (Eigen::Index c = 0; c < covariance.cols(); ++c) text << (c == 0 ? "" : ", ") << covariance(r, c);
    text << "]\n";
  }
  return text.str();
}

}  // namespace adit::optics
