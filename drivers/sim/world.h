// A scene in time: what each camera receives, and what is true.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/sim/scene.h"
#include "drivers/sim/spot.h"
#include "firmware/base/image.h"

namespace adit::sim {

/// A light as one camera receives it.
struct Reception {
  Disc disc;                ///< as if nothing stood before it, at the scene's exposure_s
  double distance_m = 0;    ///< from the camera
  std::uint64_t shown = 0;  ///< which of the kDiscPoints of its disc nothing hides
};

/// A disc is judged at its centre and on three rings of 6, 12 and 18 points; each stands for the same area.
inline constexpr int kDiscPoints = 37;
inline constexpr std::uint64_t kAllShown = (std::uint64_t{1} << kDiscPoints) - 1;
/// Their places in a disc of radius 1.
const std::array<Eigen::Vector2d, kDiscPoints>& DiscPoints();

/// Why a camera can or cannot measure an LED. The first that holds.
enum class LedView : std::uint8_t {
  kVisible,
  kOff,
  kOutside,  ///< less than kImageMarginPx + radius from the border of the image, or behind the camera
  kHidden,   ///< an occluder covers part of it at the start, middle or end of the exposure
  kCrowded,  ///< another light is not clear of it
};

/// What is true of one target at one trigger; rig frame.
struct TargetTruth {
  std::size_t target = 0;  ///< index in Scene::targets
  Eigen::Vector3d epicenter_m, direction;
  std::array<Eigen::Vector3d, base::kLedCount> leds_m;
  std::array<std::array<LedView, base::kLedCount>, 2> views;  ///< [side][LED]
  /// LEDs that both cameras can measure.
  int Visible() const;
};

/// Two lights are clear of each other when at least kClearPx of darkness lie between them: their distance in
/// the image, less the two distances from their centres at which their noise-free profiles (PSF included,
/// glare and fog not) fall below kDarkDn above the background, less half of each one's motion during the
/// exposure.
inline constexpr double kClearPx = 2;
inline constexpr double kDarkDn = 12;  ///< 8 sigma of a read noise of 1.5 DN
inline constexpr double kImageMarginPx = 4;

/// Immutable after construction: any number of threads may ask.
class World {
 public:
  explicit World(Scene scene);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const Scene& GetScene() const { return scene_; }
  const SpotPainter& Painter() const { return painter_; }
  const optics::CameraModel& Camera(base::Side side) const {
    return side == base::Side::kLeft ? scene_.rig.left : scene_.rig.right;
  }

  /// The trigger's edge and the middle of its exposure. Scene time 0 is the edge of trigger 0. An automatic
  /// exposure varies about the same middle.
  base::TimeNs TriggerNs(std::uint64_t trigger) const;
  base::TimeNs MidExposureNs(std::uint64_t trigger) const;
  double MidExposureS(std::uint64_t trigger) const;
  /// The exposure at `t_s`, as a multiple of the scene's exposure_s.
  double ExposureFactor(double t_s) const;

  /// All that shines: LEDs of all targets (four each, in order), lamps, then the mirror images of both.
  std::size_t LightCount() const { return lights_.size(); }
  /// Whether it always gives the same disc to a camera (what hides it may move).
  bool AtRest(std::size_t light) const;
  /// Nothing when it is off, behind the camera, outside the image, or too dark to matter.
  std::optional<Reception> Receive(std::size_t light, base::Side side, double t_s) const;

  std::vector<TargetTruth> TruthAt(std::uint64_t trigger) const;

 private:
  struct Source {
    const Motion* motion;
    Eigen::Vector3d place_m;
    double radius_m, surface_dn;
    const std::vector<Interval>* off;
    bool mirrored;
    double phase_rad;  ///< of its ripple
  };
  /// A light over one exposure, for the judgement whether it crowds another.
  struct Trace {
    Eigen::Vector2d centre_px;
    double extent_px;
  };

  void AddSource(const Source& source);
  Eigen::Vector3d PlaceOf(const Source& source, double t_s) const;
  Eigen::Vector3d Eye(base::Side side) const;
  bool MirrorShows(const Eigen::Vector3d& image_m, const Eigen::Vector3d& eye_m) const;
  std::uint64_t Shown(const Eigen::Vector3d& centre_m, double radius_m, base::Side side, double t_s) const;
  std::vector<std::optional<Trace>> TraceAll(base::Side side, double t_s, double factor) const;
  LedView View(std::size_t light, base::Side side, double t_s,
               const std::vector<std::optional<Trace>>& traces) const;

  Scene scene_;
  SpotPainter painter_;
  std::vector<Source> lights_;
};

}  // namespace adit::sim
