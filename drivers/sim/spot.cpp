#include "drivers/sim/spot.h"

#include <cmath>
#include <numbers>

namespace adit::sim {
namespace {

using std::numbers::pi;
using std::numbers::sqrt2;

constexpr double kTailSigmas = 5;         // beyond: 4e-6 of the peak
constexpr double kRadiiPerPx = 32;        // of the tabulated radii
constexpr double kTableSigmas = 6;        // the largest tabulated radius
constexpr double kStepsPerVariance = 32;  // of the squared distance: linear interpolation to 3e-5
constexpr int kEdgeStepsPerSigma = 64;
constexpr double kPixelPoint = 0.28867513459481287;  // 1 / (2 sqrt 3)

double NormalCdf(double x) { return 0.5 * std::erfc(-x / sqrt2); }

/// exp(-x) I0(x) for x >= 0, to 2e-7 (Abramowitz & Stegun 9.8.1 and 9.8.2).
double ScaledBessel(double x) {
  constexpr double kBend = 3.75;
  if (x < kBend) {
    const double t = (x / kBend) * (x / kBend);
    return std::exp(-x) *
           (1 + t * (3.5156229 +
                     t * (3.0899424 + t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813))))));
  }
  const double t = kBend / x;
  return (0.39894228 +
          t * (0.01328592 +
               t * (0.00225319 +
                    t * (-0.00157565 +
                         t * (0.00916281 +
                              t * (-0.02057706 + t * (0.02635537 + t * (-0.01647633 + t * 0.00392377)))))))) /
         std::sqrt(x);
}

/// What a ring of radius r, of width dr and of brightness 1, leaves at distance d of its centre, over dr.
double RingUnderGaussian(double r, double sigma_px, double d) {
  const double away = (d - r) / sigma_px;
  if (std::abs(away) > kTailSigmas + 1) return 0;
  return r / (sigma_px * sigma_px) * std::exp(-0.5 * away * away) *
         ScaledBessel(d * r / (sigma_px * sigma_px));
}

}  // namespace

SpotPainter::SpotPainter(double sigma_px)
    : sigma_px_(sigma_px), per_step_(kStepsPerVariance / (sigma_px * sigma_px)) {
  Tabulate();
  const int steps = static_cast<int>(2 * kTailSigmas) * kEdgeStepsPerSigma;
  for (int i = 0; i <= steps; ++i)
    edge_.push_back(static_cast<float>(NormalCdf(kTailSigmas - static_cast<double>(i) / kEdgeStepsPerSigma)));
}

double SpotPainter::ReachPx(double radius_px) const { return radius_px + kTailSigmas * sigma_px_ + 0.5; }

void SpotPainter::Tabulate() {
  const auto radii = static_cast<std::size_t>(std::ceil(kTableSigmas * sigma_px_ * kRadiiPerPx)) + 1;
  const auto steps_of = [this](double radius_px) {
    const double reach_px = ReachPx(radius_px) + 1;
    return static_cast<std::size_t>(reach_px * reach_px * per_step_) + 2;
  };
  const auto radius_of = [](std::size_t k) { return static_cast<double>(k) / kRadiiPerPx; };
  profiles_.resize(radii);
  for (std::size_t k = 0; k < radii; ++k) profiles_[k].resize(steps_of(radius_of(k)));
  for (std::size_t i = 0; i < steps_of(radius_of(radii - 1)); ++i) {
    const double d = std::sqrt(static_cast<double>(i) / per_step_);
    const double point = std::exp(-0.5 * d * d / (sigma_px_ * sigma_px_)) / (2 * pi * sigma_px_ * sigma_px_);
    if (i < profiles_[0].size()) profiles_[0][i] = static_cast<float>(point);
    // A disc is the sum of its rings: each radius adds one to the disc before it, by Simpson's rule.
    double disc = 0, inner = 0;
    for (std::size_t k = 1; k < radii; ++k) {
      const double r = radius_of(k);
      const double middle = RingUnderGaussian(r - 0.5 / kRadiiPerPx, sigma_px_, d);
      const double outer = RingUnderGaussian(r, sigma_px_, d);
      disc += (inner + 4 * middle + outer) / (6 * kRadiiPerPx);
      inner = outer;
      if (i < profiles_[k].size()) profiles_[k][i] = static_cast<float>(disc / (pi * r * r));
    }
  }
}

const SpotPainter::Profile* SpotPainter::Find(double radius_px) const {
  const auto i = static_cast<std::size_t>(std::lround(radius_px * kRadiiPerPx));
  return i < profiles_.size() ? &profiles_[i] : nullptr;
}

double SpotPainter::LargeSurface(const Disc& disc) const {
  // A straight edge wrapped round a disc has too much light by this share of the disc's area.
  const double excess = sigma_px_ * sigma_px_ / (disc.radius_px * disc.radius_px);
  return disc.flux_dn / (pi * disc.radius_px * disc.radius_px * (1 + excess));
}

double SpotPainter::Edge(double outside_px) const {
  const double at = (outside_px / sigma_px_ + kTailSigmas) * kEdgeStepsPerSigma;
  if (at <= 0) return 1;
  const auto i = static_cast<std::size_t>(at);
  if (i + 1 >= edge_.size()) return 0;
  const double share = at - static_cast<double>(i);
  return (1 - share) * edge_[i] + share * edge_[i + 1];
}

double SpotPainter::Value(const Disc& disc, double distance_px) const {
  const Profile* const profile = Find(disc.radius_px);
  if (profile == nullptr) return LargeSurface(disc) * Edge(distance_px - disc.radius_px);
  const double step = distance_px * distance_px * per_step_;
  if (step >= static_cast<double>(profile->size() - 1)) return 0;
  const auto i = static_cast<std::size_t>(step);
  const double share = step - static_cast<double>(i);
  return disc.flux_dn * ((1 - share) * (*profile)[i] + share * (*profile)[i + 1]);
}

double SpotPainter::ExtentPx(const Disc& disc, double level_dn) const {
  if (Value(disc, 0) <= level_dn) return 0;
  double inside = 0, outside = ReachPx(disc.radius_px);
  constexpr int kHalvings = 20;  // below 1e-4 px for any radius
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (Value(disc, middle) > level_dn ? inside : outside) = middle;
  }
  return inside;
}

void SpotPainter::AddSmall(const Disc& disc, const Profile& profile, const PixelBox& part,
                           Canvas& canvas) const {
  const auto flux = static_cast<float>(disc.flux_dn / 4);
  const auto end = static_cast<float>(profile.size() - 1);
  const auto per_step = static_cast<float>(per_step_);
  for (int y = part.y0; y < part.y1; ++y) {
    float* const row = canvas.Row(y) - canvas.Box().x0;
    const auto up = static_cast<float>(y - disc.y_px - kPixelPoint);
    const auto down = static_cast<float>(y - disc.y_px + kPixelPoint);
    for (int x = part.x0; x < part.x1; ++x) {
      const auto left = static_cast<float>(x - disc.x_px - kPixelPoint);
      const auto right = static_cast<float>(x - disc.x_px + kPixelPoint);
      float sum = 0;
      for (const float at : {left * left + up * up, right * right + up * up, left * left + down * down,
                             right * right + down * down}) {
        const float step = at * per_step;
        if (step >= end) continue;
        const auto i = static_cast<std::size_t>(step);
        const float share = step - static_cast<float>(i);
        sum += profile[i] + share * (profile[i + 1] - profile[i]);
      }
      row[x] += flux * sum;
    }
  }
}

void SpotPainter::AddLarge(const Disc& disc, const PixelBox& part, Canvas& canvas) const {
  const double surface_dn = LargeSurface(disc);
  for (int y = part.y0; y < part.y1; ++y) {
    float* const row = canvas.Row(y) - canvas.Box().x0;
    const double dy = y - disc.y_px;
    for (int x = part.x0; x < part.x1; ++x) {
      // One point a pixel: across a straight edge the pixel's width adds 1/12 px^2 to the variance of the
      // PSF, which moves no centroid.
      const double dx = x - disc.x_px;
      const double outside_px = std::sqrt(dx * dx + dy * dy) - disc.radius_px;
      row[x] += static_cast<float>(surface_dn * Edge(outside_px));
    }
  }
}

void SpotPainter::Add(const Disc& disc, Canvas& canvas) const {
  const PixelBox part = PixelBox::Around(disc.x_px, disc.y_px, ReachPx(disc.radius_px)).Cut(canvas.Box());
  if (part.Empty() || disc.flux_dn <= 0) return;
  if (const Profile* const profile = Find(disc.radius_px)) {
    AddSmall(disc, *profile, part, canvas);
  } else {
    AddLarge(disc, part, canvas);
  }
  canvas.Mark(part);
}

void AddHalo(const Disc& disc, double sigma_px, Canvas& canvas) {
  constexpr double kFaintDn = 0.02;  // far below one DN's rounding
  const double peak_dn = disc.flux_dn / (2 * pi * sigma_px * sigma_px);
  if (peak_dn <= kFaintDn) return;
  const double reach_px = sigma_px * std::sqrt(2 * std::log(peak_dn / kFaintDn));
  const PixelBox part = PixelBox::Around(disc.x_px, disc.y_px, reach_px).Cut(canvas.Box());
  if (part.Empty()) return;
  const auto bell = [sigma_px](double d) { return std::exp(-0.5 * d * d / (sigma_px * sigma_px)); };
  std::vector<float> across;
  for (int x = part.x0; x < part.x1; ++x) across.push_back(static_cast<float>(bell(x - disc.x_px)));
  for (int y = part.y0; y < part.y1; ++y) {
    float* const row = &canvas.At(part.x0, y);
    const auto scale = static_cast<float>(peak_dn * bell(y - disc.y_px));
    for (std::size_t i = 0; i < across.size(); ++i) row[i] += scale * across[i];
  }
  canvas.Mark(part);
}

}  // namespace adit::sim
