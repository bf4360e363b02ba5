#include "tests/support/centroid_trials.h"

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>

#include "firmware/detect/detector.h"

namespace adit::support {
namespace {

constexpr int kRows = 7, kColumns = 8, kCellPx = 42;

using Cell = std::vector<RenderedSpot>;

/// The LEDs of one cell about the place (x, y).
Cell Draw(const TrialKind& kind, double x_px, double y_px, std::mt19937& random) {
  std::uniform_real_distribution<double> phase(-0.5, 0.5), turn(0, 2 * M_PI);
  const double smear_angle = turn(random), angle = turn(random);
  RenderedSpot spot{x_px + phase(random),
                    y_px + phase(random),
                    kind.sigma_px,
                    kind.peak_dn,
                    kind.smear_px * std::cos(smear_angle),
                    kind.smear_px * std::sin(smear_angle)};
  if (kind.gap_px == 0) return {spot};
  RenderedSpot second = spot;
  const double dx = kind.gap_px / 2 * std::cos(angle), dy = kind.gap_px / 2 * std::sin(angle);
  spot.x_px -= dx, spot.y_px -= dy;
  second.x_px += dx, second.y_px += dy;
  second.peak_dn *= kind.second_peak;
  return {spot, second};
}

double BoundPx2(const Cell& cell, const TrialKind& kind) {
  const auto places = static_cast<Eigen::Index>(2 * cell.size());
  return CramerRaoPx2(cell, kind.noise, kind.bits).topLeftCorner(places, places).trace() /
         static_cast<double>(places);
}

/// Adds the errors of one cell's LEDs.
void Compare(const Cell& cell, const detect::BlobSet& blobs, TrialErrors& errors, Eigen::Vector2d& sum_px) {
  for (const RenderedSpot& spot : cell) {
    ++errors.spots;
    const detect::Blob* const blob = Nearest(blobs, spot, 1.2);
    errors.missing += blob == nullptr ? 1 : 0;
    if (blob == nullptr) continue;
    const Eigen::Vector2d error_px = blob->raw_px - Eigen::Vector2d(spot.x_px, spot.y_px);
    errors.rms_px += error_px.squaredNorm() / 2;
    errors.nees += error_px.dot(blob->covariance_px2.inverse() * error_px);
    errors.saturated += blob->saturated ? 1 : 0;
    sum_px += error_px;
  }
}

}  // namespace

optics::CameraModel Pinhole(int width_px, int height_px) {
  optics::CameraModel camera;
  camera.fu_px = camera.fv_px = 3378;
  camera.cu_px = width_px / 2.0, camera.cv_px = height_px / 2.0;
  camera.width_px = width_px, camera.height_px = height_px;
  return camera;
}

const detect::Blob* Nearest(const detect::BlobSet& blobs, const RenderedSpot& spot, double within_px) {
  const detect::Blob* best = nullptr;
  for (const detect::Blob& blob : blobs.blobs) {
    const double away_px = (blob.raw_px - Eigen::Vector2d(spot.x_px, spot.y_px)).norm();
    if (away_px < within_px) best = &blob, within_px = away_px;
  }
  return best;
}

Eigen::MatrixXd CramerRaoPx2(const std::vector<RenderedSpot>& spots, const SensorNoise& noise, int bits) {
  constexpr double kStep = 1e-4;
  constexpr int kMarginPx = 14;
  const auto count = static_cast<Eigen::Index>(spots.size()), parameters = 3 * count + 2;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(parameters, parameters);
  const double full_dn = ((1 << bits) - 1) / static_cast<double>(1 << (bits - 8));
  const double rounding_dn2 = std::pow(0.5, 2 * (bits - 8)) / 12;
  const auto sum = [&](const std::vector<RenderedSpot>& of, int x, int y) {
    double light_dn = 0;
    for (const RenderedSpot& s : of) light_dn += LightDn(s, x, y);
    return light_dn;
  };
  // All spots' parameter k changed by `step`; of one of them, or of all.
  const auto changed = [&](Eigen::Index k, double step) {
    std::vector<RenderedSpot> out = spots;
    if (k == 3 * count) {
      for (RenderedSpot& s : out) s.sigma_px += step;
    } else if (k < 2 * count) {
      (k % 2 == 0 ? out[static_cast<std::size_t>(k / 2)].x_px : out[static_cast<std::size_t>(k / 2)].y_px) +=
          step;
    } else {
      out[static_cast<std::size_t>(k - 2 * count)].peak_dn += step;
    }
    return out;
  };
  const int cx = static_cast<int>(std::lround((spots.front().x_px + spots.back().x_px) / 2));
  const int cy = static_cast<int>(std::lround((spots.front().y_px + spots.back().y_px) / 2));
  std::vector<std::vector<RenderedSpot>> more, less;
  for (Eigen::Index k = 0; k + 1 < parameters; ++k)
    more.push_back(changed(k, kStep)), less.push_back(changed(k, -kStep));
  for (int y = cy - kMarginPx; y <= cy + kMarginPx; ++y) {
    for (int x = cx - kMarginPx; x <= cx + kMarginPx; ++x) {
      const double light_dn = sum(spots, x, y);
      if (kTrialBackgroundDn + light_dn > full_dn) continue;
      Eigen::VectorXd slope = Eigen::VectorXd::Ones(parameters);  // the last is the background's
      for (Eigen::Index k = 0; k + 1 < parameters; ++k)
        slope[k] =
            (sum(more[static_cast<std::size_t>(k)], x, y) - sum(less[static_cast<std::size_t>(k)], x, y)) /
            (2 * kStep);
      information += slope * slope.transpose() /
                     (noise.read_dn * noise.read_dn + light_dn / noise.electrons_per_dn + rounding_dn2);
    }
  }
  return information.inverse().topLeftCorner(2 * count, 2 * count);
}

TrialErrors Measure(const TrialKind& kind, int images, unsigned seed) {
  std::mt19937 random(seed);
  detect::DetectorOptions options;
  options.read_noise_dn = kind.noise.read_dn, options.electrons_per_dn = kind.noise.electrons_per_dn;
  detect::Detector detector(Pinhole(), options);
  const auto blobs = std::make_unique<detect::BlobSet>();
  TrialErrors errors;
  Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
  double bound_px2 = 0;
  for (int i = 0; i < images; ++i) {
    RenderedImage image(kTrialWidthPx, kTrialHeightPx, kind.bits);
    image.Background(kTrialBackgroundDn, kind.slope_dn, kind.slope_dn / 2);
    std::vector<Cell> cells;
    for (int n = 0; n < kRows * kColumns; ++n) {
      cells.push_back(Draw(kind, 40.0 + kCellPx * (n % kColumns), 30.0 + kCellPx * (n / kColumns), random));
      for (const RenderedSpot& spot : cells.back()) image.Add(spot);
    }
    image.Expose(kind.noise, &random);
    detector.Detect(image.Frame(), {}, *blobs);
    errors.surplus += static_cast<int>(blobs->blobs.size());
    for (const Cell& cell : cells) Compare(cell, *blobs, errors, sum_px);
    constexpr int kBounds = 7;  // of so many cells: it hardly depends on the phase
    for (int n = 0; n < kBounds && i == 0; ++n)
      bound_px2 += BoundPx2(cells[static_cast<std::size_t>(8 * n)], kind) / kBounds;
  }
  const int found = errors.spots - errors.missing;
  errors.surplus -= found;
  errors.rms_px = std::sqrt(errors.rms_px / found);
  errors.nees /= found;
  errors.bound_px = std::sqrt(bound_px2);
  errors.offset_px = sum_px.norm() / found;
  std::printf(
      "peak %5.1f DN, sigma %.1f px, smear %.1f px, gap %4.1f px (x %.1f), slope %.2f DN, %2d bits: %5d "
      "spots, %d missing, "
      "%d surplus, rms %.4f px, %.3f x bound, NEES %.3f, offset %.4f px\n",
      kind.peak_dn, kind.sigma_px, kind.smear_px, kind.gap_px, kind.second_peak, kind.slope_dn, kind.bits,
      errors.spots, errors.missing, errors.surplus, errors.rms_px, errors.PerBound(), errors.nees,
      errors.offset_px);
  return errors;
}

}  // namespace adit::support
