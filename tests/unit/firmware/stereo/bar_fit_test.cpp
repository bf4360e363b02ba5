#include "firmware/stereo/bar_fit.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <cmath>

#include "firmware/stereo/triangulate.h"
#include "tests/unit/firmware/stereo/observations.h"

#include <CppUTest/TestHarness.h>

using adit::stereo::BarFit;
using adit::stereo::BarObservations;
using adit::stereo::FitAllowance;
using adit::stereo::FitBar;
using adit::stereo::LedPlaces;
using adit::stereo_tests::Observe;
using adit::support::SyntheticBar;
using Eigen::Vector3d;

namespace {

LedPlaces TriangulateAll(const adit::stereo::Views& views, const BarObservations& observations) {
  LedPlaces places;
  for (std::size_t i = 0; i < 4; ++i) {
    // Of a hidden LED nothing may be read.
    places[i] = adit::stereo::SeenInBoth(observations[i])
                    ? adit::stereo::Triangulate(views, observations[i]).value().point_b_m
                    : Vector3d::Constant(std::nan(""));
  }
  return places;
}

/// Hides centroids: bit 2 i + side of `mask` hides LED i + 1 in that image.
BarObservations Hidden(BarObservations observations, unsigned mask) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      if ((mask >> (2 * i + side) & 1) != 0) observations[i][side] = {{}, {}, false};
    }
  }
  return observations;
}

// Nothing hidden; LED 1 in the right image; LED 3 in both; LED 2 in the left and LED 4 in the right; LEDs 2
// and 4 in both.
constexpr std::array<unsigned, 5> kHidden{0, 0b10, 0b110000, 0b10000100, 0b11001100};

/// The bar's point by equation 4.6 of the seed: the mean of the unit vectors between neighbours.
Vector3d SeedEpicenter(const LedPlaces& p, const adit::base::Target& target) {
  const Vector3d mean =
      ((p[1] - p[0]).normalized() + (p[2] - p[1]).normalized() + (p[3] - p[2]).normalized()) / 3;
  return p[3] - (target.leds_m[3] - target.epicenter_m) * mean;
}

/// Bound of a bar's five parameters, about the truth: LED 1 (3) and the direction in a tangent plane (2).
Eigen::Matrix<double, 5, 5> BarBound(const adit::support::SyntheticRig& rig, const SyntheticBar& bar,
                                     double sigma_px) {
  const Vector3d u = bar.direction_b.unitOrthogonal(), v = bar.direction_b.cross(u);
  return adit::stereo_tests::CramerRao<5>(rig, sigma_px, [&](const Eigen::Matrix<double, 5, 1>& p) {
    SyntheticBar moved = bar;
    moved.led1_b_m += p.head<3>();
    moved.direction_b = (bar.direction_b + p[3] * u + p[4] * v).normalized();
    std::vector<Vector3d> points;
    for (const double place : bar.target.leds_m) points.push_back(moved.Point(place));
    return points;
  });
}

/// The bound of a point at `place_m` along the bar.
Eigen::Matrix3d PointBound(const adit::support::SyntheticRig& rig, const SyntheticBar& bar, double place_m,
                           double sigma_px) {
  const Vector3d u = bar.direction_b.unitOrthogonal(), v = bar.direction_b.cross(u);
  Eigen::Matrix<double, 3, 5> slope;
  slope << Eigen::Matrix3d::Identity(), place_m * u, place_m * v;
  return slope * BarBound(rig, bar, sigma_px) * slope.transpose();
}

struct BarReprojection {
  adit::optics::CameraModel camera;
  Eigen::Matrix3d r;
  Vector3d t;
  Eigen::Vector2d px;
  double place_m;
  template <class T>
  bool operator()(const T* led1, const T* direction, T* residual) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const V p =
        r.cast<T>() * (Eigen::Map<const V>(led1) + T(place_m) * Eigen::Map<const V>(direction)) + t.cast<T>();
    residual[0] = p.x() / p.z() * camera.fu_px + camera.cu_px - px.x();
    residual[1] = p.y() / p.z() * camera.fv_px + camera.cv_px - px.y();
    return true;
  }
};

/// Epicenter and direction by Ceres, for equal noise everywhere.
std::pair<Vector3d, Vector3d> ByCeres(const adit::optics::Rig& rig, const SyntheticBar& start,
                                      const BarObservations& seen) {
  Vector3d led1 = start.led1_b_m, direction = start.direction_b;
  ceres::Problem problem;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      const Eigen::Matrix3d r = side == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : rig.T_r_l.rotation;
      const Vector3d t = side == 0 ? Vector3d(Vector3d::Zero()) : rig.T_r_l.translation_m;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<BarReprojection, 2, 3, 3>(new BarReprojection{
              side == 0 ? rig.left : rig.right, r, t, seen[i][side].px, start.target.leds_m[i]}),
          nullptr, led1.data(), direction.data());
    }
  }
  problem.SetManifold(direction.data(), new ceres::SphereManifold<3>());
  ceres::Solver::Options options;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.max_num_iterations = 100;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {led1 + start.target.epicenter_m * direction, direction};
}

}  // namespace

TEST_GROUP(BarFit) {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  adit::stereo::Views views = adit::stereo::MakeViews(rig.AsRig());
  adit::support::SyntheticScene random{rig, 23};
  std::vector<SyntheticBar> bars{
      SyntheticBar::At(adit::support::SeedTargetOne(), {3, 0.5, 25}, {1, 0.2, 0.3}),
      SyntheticBar::At(adit::support::SeedTargetTwo(), {5, -1, 40}, {-0.3, 1, -0.4}),
      SyntheticBar::At(adit::support::ShortTarget(), {4, 1, 30}, {0.5, 0.1, -0.8}),
      SyntheticBar::At(adit::support::SeedTargetOne(), {12, 3, 90}, {-1, 0.5, 0.2}),
  };
};

TEST(BarFit, FindsABarExactlyWithoutNoise) {
  for (const SyntheticBar& bar : bars) {
    const auto seen = Observe(rig, bar, 0, random);
    const auto fit = FitBar(views, bar.target, seen, TriangulateAll(views, seen));
    CHECK(!!fit);
    CHECK((fit->PointM(bar.target, bar.target.epicenter_m) - bar.Epicenter()).norm() < 1e-7);
    CHECK((fit->bar.direction_b - bar.direction_b).norm() < 1e-8);
    CHECK(fit->residuals_px.norm() < 1e-6);
  }
}

TEST(BarFit, AgreesWithCeres) {
  for (const SyntheticBar& bar : bars) {
    const auto seen = Observe(rig, bar, 0.05, random);
    const auto fit = FitBar(views, bar.target, seen, TriangulateAll(views, seen));
    CHECK(!!fit);
    const auto [epicenter, direction] = ByCeres(rig.AsRig(), bar, seen);
    const double sigma_m = std::sqrt(fit->PointCovarianceM2(bar.target, bar.target.epicenter_m).trace());
    CHECK((fit->PointM(bar.target, bar.target.epicenter_m) - epicenter).norm() < 1e-3 * sigma_m);
    CHECK((fit->bar.direction_b - direction).norm() < 1e-3 * sigma_m);
  }
}

TEST(BarFit, ReachesTheCramerRaoBoundAndBeatsSingleLeds) {
  constexpr double kSigmaPx = 0.05;
  constexpr int kTrials = 4000;
  for (const SyntheticBar& bar : bars) {
    const double place_m = bar.target.epicenter_m;
    const Eigen::Matrix3d bound = PointBound(rig, bar, place_m, kSigmaPx);
    double rigid_m2 = 0, single_m2 = 0, rigid_leds_m2 = 0, single_leds_m2 = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto seen = Observe(rig, bar, kSigmaPx, random);
      const auto leds = TriangulateAll(views, seen);
      const auto fit = FitBar(views, bar.target, seen, leds);
      CHECK(!!fit);
      rigid_m2 += (fit->PointM(bar.target, place_m) - bar.Epicenter()).squaredNorm() / kTrials;
      single_m2 += (SeedEpicenter(leds, bar.target) - bar.Epicenter()).squaredNorm() / kTrials;
      for (std::size_t i = 0; i < 4; ++i) {
        const double led_m = bar.target.leds_m[i];
        rigid_leds_m2 += (fit->PointM(bar.target, led_m) - bar.Point(led_m)).squaredNorm() / kTrials;
        single_leds_m2 += (leds[i] - bar.Point(led_m)).squaredNorm() / kTrials;
      }
    }
    CHECK(std::sqrt(rigid_m2 / bound.trace()) < 1.05);
    CHECK(std::sqrt(rigid_m2 / bound.trace()) > 0.95);
    CHECK(std::sqrt(single_m2 / rigid_m2) > 1.6);
    CHECK(std::sqrt(single_leds_m2 / rigid_leds_m2) > 1.6);
  }
}

TEST(BarFit, StatesItsUncertaintyHonestlyWhateverIsHidden) {
  constexpr int kTrials = 2000;
  for (const SyntheticBar& bar : bars) {
    // Two LEDs 0.65 m apart, 90 m away, are beyond linear propagation at 0.05 px: their depths differ by
    // 40 mm of noise.
    const double sigma_px = bar.led1_b_m.z() > 80 ? 0.02 : 0.05;
    for (const unsigned mask : kHidden) {
      double nees_place = 0, nees_direction = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        const auto seen = Hidden(Observe(rig, bar, sigma_px, random), mask);
        const auto fit = FitBar(views, bar.target, seen, TriangulateAll(views, seen));
        CHECK(!!fit);
        const double place_m = bar.target.epicenter_m;
        const Vector3d error = fit->PointM(bar.target, place_m) - bar.Epicenter();
        nees_place += error.dot(fit->PointCovarianceM2(bar.target, place_m).inverse() * error) / kTrials;
        // Two degrees of freedom in the plane across the true direction.
        Eigen::Matrix<double, 3, 2> plane;
        plane.col(0) = bar.direction_b.unitOrthogonal();
        plane.col(1) = bar.direction_b.cross(plane.col(0));
        const Eigen::Vector2d turn = plane.transpose() * fit->bar.direction_b;
        const Eigen::Matrix2d covariance = plane.transpose() * fit->DirectionCovariance() * plane;
        nees_direction += turn.dot(covariance.inverse() * turn) / kTrials;
      }
      DOUBLES_EQUAL(3, nees_place, 4 * std::sqrt(6.0 / kTrials));
      DOUBLES_EQUAL(2, nees_direction, 4 * std::sqrt(4.0 / kTrials));
    }
  }
}

TEST(BarFit, ItsChiSquareHasTwoDegreesOfFreedomForEachCentroidLessFive) {
  constexpr double kSigmaPx = 0.05;
  constexpr int kTrials = 2000;
  for (const unsigned mask : kHidden) {
    double mean = 0;
    int freedom = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto seen = Hidden(Observe(rig, bars[0], kSigmaPx, random), mask);
      const auto fit = FitBar(views, bars[0].target, seen, TriangulateAll(views, seen));
      mean += ChiSquare(views, bars[0].target, seen, *fit, {0, 1e-9, 1e-12}) / kTrials;
      freedom = 2 * adit::stereo::SeenCount(seen) - 5;
    }
    DOUBLES_EQUAL(freedom, mean, 4 * std::sqrt(2.0 * freedom / kTrials));
  }
}

TEST(BarFit, FindsABarThatSeemsLongerOrShorterThanItIs) {
  // A calibration that is off by some urad of yaw stretches all that is far away; from a short base the
  // length then says more of how the bar leans than the LEDs' own depths do.
  const auto narrow = adit::support::ToedInRig(3);
  const auto narrow_views = adit::stereo::MakeViews(narrow.AsRig());
  for (double distance_m = 20; distance_m <= 120; distance_m += 20) {
    for (int per_mille = -5; per_mille <= 5; ++per_mille) {
      auto stretched = adit::support::SeedTargetOne();
      for (double& place_m : stretched.leds_m) place_m *= 1 + 1e-3 * per_mille;
      const auto bar =
          SyntheticBar::At(stretched, adit::support::Ahead(narrow, distance_m), Vector3d(1, 0, 0.02));
      const auto observations = Observe(narrow, bar, 0.0084, random);
      CHECK(FitBar(narrow_views, adit::support::SeedTargetOne(), observations,
                   TriangulateAll(narrow_views, observations))
                .has_value());
    }
  }
}

TEST(BarFit, DeclinesABarOfWhichOneLedIsSeenInBothImages) {
  const auto seen = Hidden(Observe(rig, bars[0], 0, random), 0b01101000);
  CHECK_FALSE(FitBar(views, bars[0].target, seen, TriangulateAll(views, seen)).has_value());
}

TEST(BarFit, ItsChiSquareForgivesATurnedRigButNotABentBar) {
  const FitAllowance allowance{0.05, 0.5, 0.0025};
  const SyntheticBar& bar = bars[0];
  auto seen = Observe(rig, bar, 0.02, random);
  const auto chi_square = [&] {
    const auto fit = FitBar(views, bar.target, seen, TriangulateAll(views, seen));
    return fit ? ChiSquare(views, bar.target, seen, *fit, allowance) : HUGE_VAL;
  };
  CHECK(chi_square() < 20);
  for (auto& pair : seen) pair[1].px += Eigen::Vector2d(0.5, -0.6);
  CHECK(chi_square() < 20);
  seen[2][1].px.y() += 1;
  CHECK(chi_square() > 100);
}

TEST(BarFit, DeclinesABarBehindTheCameras) {
  const auto seen = Observe(rig, bars[0], 0, random);
  LedPlaces behind = TriangulateAll(views, seen);
  for (Vector3d& p : behind) p = -p;
  CHECK_FALSE(FitBar(views, bars[0].target, seen, behind).has_value());
}

TEST(BarFit, DeclinesLedsThatStandAtOnePlace) {
  const auto seen = Observe(rig, bars[0], 0, random);
  LedPlaces same;
  same.fill(Vector3d(3, 0, 30));
  CHECK_FALSE(FitBar(views, bars[0].target, seen, same).has_value());
}
