// The projective invariant of four points on a line.
#pragma once

#include <array>

namespace adit::identify {

/// Places of four points along their common line, in order.
using LinePlaces = std::array<double, 4>;

/// The cross ratio lambda = (|AB|/|BD|) / (|AC|/|CD|) of four points in order on a line (seed 2.2.2.1,
/// eq. 2.1, corrected); in (0, 1), unchanged by projection, and the same read from either end. NaN or
/// infinite when points coincide.
double CrossRatio(const LinePlaces& places);

/// Derivatives of the cross ratio by the four places.
LinePlaces CrossRatioSlopes(const LinePlaces& places);

/// The p2 invariant J(lambda) (seed eq. 2.2, 2.3; Meer, Lenz, Ramakrishna 1998): unchanged by projection
/// and by relabelling; from 2 (two points meet) to 2.8 (lambda = 1/2).
double P2(double cross_ratio);

/// dJ / dlambda; 0 at lambda = 1/2.
double P2Slope(double cross_ratio);

}  // namespace adit::identify
