#include "firmware/track/bar_filter.h"

#include <cmath>
#include <limits>

#include "tests/support/nees.h"
#include "tests/unit/firmware/track/simulated_bar.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::base::TimeNs;
using adit::tests::SimulatedBar;
using adit::track::BarFilter;
using adit::track::BarPlace;
using adit::track::MotionOptions;
using Eigen::Vector3d;

namespace {

/// One bar that is measured at irregular times, and what the filter makes of it.
struct Chase {
  Chase(unsigned seed, const Vector3d& sigma_m, double sigma_rad)
      : truth(seed), centre_sigma_m(sigma_m), direction_sigma_rad(sigma_rad), filter(StartedFilter()) {}

  /// As fast as machines turn: the filter is linear in the turns between two measurements, and 0.4 rad of
  /// them make it 3 % too careful.
  static MotionOptions OfMachines() {
    MotionOptions options;
    options.turning_rad_per_s2_per_sqrt_hz = options.rate_rad_per_s = 0.5;
    return options;
  }

  BarFilter StartedFilter() {
    truth.StartAt({3, -1, 50}, options.speed_m_per_s, options.rate_rad_per_s);
    return {options, now_ns, truth.Measure(centre_sigma_m, direction_sigma_rad)};
  }

  void Move(TimeNs duration_ns) {
    now_ns += duration_ns;
    truth.Move(1e-9 * static_cast<double>(duration_ns), options.acceleration_m_per_s2_per_sqrt_hz,
               options.turning_rad_per_s2_per_sqrt_hz);
    filter.Advance(now_ns);
  }

  /// The squared innovation.
  double Measure() {
    const BarPlace measured = truth.Measure(centre_sigma_m, direction_sigma_rad);
    const double chi_square = filter.ChiSquare(measured).value();
    filter.Update(measured);
    return chi_square;
  }

  TimeNs Irregular() {
    return static_cast<TimeNs>(truth.Uniform(8e6, truth.Uniform(0, 1) < 0.1 ? 1.5e8 : 4e7));
  }

  /// Squared error in units of the covariance: 10 degrees of freedom.
  double SquaredError() const {
    const Vector3d estimated = filter.Place().direction_b;
    const Vector3d across = truth.Direction() - estimated.dot(truth.Direction()) * estimated;
    const double angle_rad = std::atan2(across.norm(), estimated.dot(truth.Direction()));
    Eigen::Matrix<double, 10, 1> error;
    error << truth.CentreM() - filter.Place().point_b_m,
        filter.Tangent().transpose() * across * (angle_rad / across.norm()),
        truth.VelocityMPerS() - filter.VelocityMPerS(),
        filter.Tangent().transpose() * (truth.DirectionRate() - filter.DirectionRate());
    return adit::support::Nees(error, filter.GetCovariance());
  }

  MotionOptions options = OfMachines();
  SimulatedBar truth;
  Vector3d centre_sigma_m;
  double direction_sigma_rad;
  TimeNs now_ns = kNsPerS;
  BarFilter filter;
};

/// 95 % of the means of `count` values of chi-square of `freedoms` lie this near `freedoms`; wide enough at
/// these counts for the normal distribution to serve.
double MeanWithin(double freedoms, double count) { return 1.96 * std::sqrt(2 * freedoms / count); }

struct Noise {
  Vector3d centre_m;
  double direction_rad;
};

}  // namespace

TEST_GROUP(BarFilter) {
  // At 20, 50 and 100 m from a base of 9 m, roughly.
  const std::array<Noise, 3> noises{Noise{{1e-4, 1e-4, 2e-4}, 2e-4}, Noise{{3e-4, 2e-4, 2e-3}, 1e-3},
                                    Noise{{4e-4, 4e-4, 5e-3}, 4e-3}};
};

TEST(BarFilter, InnovationsAreAsLargeAsTheirCovarianceSaysSeeds100To139) {
  for (const Noise& noise : noises) {
    double sum = 0;
    int count = 0;
    for (unsigned seed = 100; seed < 140; ++seed) {
      Chase chase(seed, noise.centre_m, noise.direction_rad);
      for (int i = 0; i < 40; ++i, ++count) {
        chase.Move(chase.Irregular());
        sum += chase.Measure();
      }
    }
    DOUBLES_EQUAL(5, sum / count, MeanWithin(5, count));
  }
}

TEST(BarFilter, ErrorsAreAsLargeAsTheirCovarianceSaysSeeds1000To2499) {
  constexpr unsigned kRuns = 500;
  unsigned seed = 1000;
  for (const Noise& noise : noises) {
    double measured = 0, coasted = 0;
    for (unsigned run = 0; run < kRuns; ++run, ++seed) {
      Chase chase(seed, noise.centre_m, noise.direction_rad);
      for (int i = 0; i < 12; ++i) {
        chase.Move(chase.Irregular());
        chase.Measure();
      }
      measured += chase.SquaredError();
      chase.Move(200 * kNsPerMs);
      coasted += chase.SquaredError();
    }
    DOUBLES_EQUAL(10, measured / kRuns, MeanWithin(10, kRuns));
    DOUBLES_EQUAL(10, coasted / kRuns, MeanWithin(10, kRuns));
  }
}

TEST(BarFilter, IsSurerThanOneMeasurementWhereTheMeasurementIsPoor) {
  Chase chase(1, {4e-3, 4e-3, 0.05}, 0.05);
  for (int i = 0; i < 60; ++i) {
    chase.Move(16 * kNsPerMs);
    chase.Measure();
  }
  CHECK(std::sqrt(chase.filter.Place().covariance(2, 2)) < 0.6 * 0.05);
}

TEST(BarFilter, FollowsAGreatCircleAtAConstantRate) {
  // Without noise and at rest in place: the direction turns by 1 rad/s about y.
  MotionOptions options;
  const auto place_at = [](double angle_rad) {
    return BarPlace{
        {0, 0, 30}, {std::cos(angle_rad), 0, -std::sin(angle_rad)}, Eigen::Matrix<double, 6, 6>::Zero()};
  };
  BarFilter filter(options, 0, place_at(0));
  for (int i = 1; i <= 50; ++i) {
    filter.Advance(i * 20 * kNsPerMs);
    filter.Update(place_at(0.02 * i));
  }
  filter.Advance(kNsPerS + 500 * kNsPerMs);
  const Vector3d direction = filter.Place().direction_b;
  DOUBLES_EQUAL(1.5, std::atan2(-direction.z(), direction.x()), 1e-6);
  DOUBLES_EQUAL(1, direction.norm(), 1e-12);
}

TEST(BarFilter, KeepsItsCovarianceSymmetricAndPositiveThroughHoursOfPairs) {
  Chase chase(3, {1e-6, 1e-6, 1e-2}, 1e-6);  // as lopsided as it comes
  for (int i = 0; i < 5000; ++i) {
    chase.filter.Advance(chase.now_ns += i % 97 == 0 ? 400 * kNsPerMs : 100'000);
    chase.filter.Update(chase.truth.Measure(chase.centre_sigma_m, chase.direction_sigma_rad));
  }
  const BarFilter::Covariance& covariance = chase.filter.GetCovariance();
  DOUBLES_EQUAL(0, (covariance - covariance.transpose()).norm(), 0);
  CHECK(adit::support::Eigenvalues(covariance)[0] > 0);
}

TEST(BarFilter, HasNoOpinionOnABarThatPointsElsewhereOrIsNoNumber) {
  Chase chase(4, {1e-3, 1e-3, 1e-3}, 1e-3);
  BarPlace turned = chase.filter.Place();
  turned.direction_b = -turned.direction_b;
  CHECK_FALSE(chase.filter.ChiSquare(turned).has_value());
  BarPlace broken = chase.filter.Place();
  broken.point_b_m.z() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(chase.filter.ChiSquare(broken).has_value());
  broken = chase.filter.Place();
  broken.covariance(0, 0) = std::numeric_limits<double>::infinity();
  CHECK_FALSE(chase.filter.ChiSquare(broken).has_value());
}

TEST(BarFilter, DoesNotGoBackInTime) {
  Chase chase(5, {1e-3, 1e-3, 1e-3}, 1e-3);
  const BarPlace before = chase.filter.Place();
  chase.filter.Advance(chase.now_ns - kNsPerS);
  CHECK(chase.filter.ExposureNs() == chase.now_ns);
  CHECK(chase.filter.Place().covariance == before.covariance);
}
