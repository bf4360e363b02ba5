// Plots as inline SVG that stay readable in black and white: series differ by mark and dash, not by colour
// alone.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace adit::host {

/// How a series is drawn.
enum class PlotMark { kDot, kRing, kCross, kSquare, kTriangle, kLine, kDashedLine, kDottedLine };

/// Points, or a line through them.
struct PlotSeries {
  std::string name;  ///< in the legend; empty: none
  PlotMark mark = PlotMark::kDot;
  std::vector<Eigen::Vector2d> points;  ///< those that are not finite are left out
  std::vector<double> sigma;            ///< half height of error bars, one a point; empty: none
};

/// Arrows, such as residuals, drawn `magnified` times longer than they are.
struct PlotVectors {
  std::string name;
  std::string unit;
  double magnified = 1;
  std::vector<Eigen::Vector2d> places, steps;  ///< both in the axes' units
};

/// Counts in classes of equal width.
struct PlotHistogram {
  std::string name;
  double from = 0, width = 1;
  std::vector<double> counts;
};

/// Cells of an image or map, row by row from the axes' origin; each shows its value. Zero is hatched: nothing
/// there.
struct PlotCells {
  std::string name;
  int columns = 0, rows = 0;
  std::vector<double> values;
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Ones();
};

struct PlotAxis {
  std::string label;  ///< with the unit
  bool logarithmic = false;
  bool reversed = false;                           ///< rows of an image grow downwards
  std::optional<std::pair<double, double>> range;  ///< empty: what the data need
};

struct Plot {
  std::string title, note;  ///< the note stands below: what the reader should see
  PlotAxis x, y;
  bool same_scale = false;  ///< a metre is as long in x as in y: maps and images
  std::vector<PlotSeries> series;
  std::vector<PlotVectors> vectors;
  std::vector<PlotHistogram> histograms;
  std::vector<PlotCells> cells;
};

/// `count` classes of equal width over the values, from the smallest to the largest.
PlotHistogram HistogramOf(const std::string& name, const std::vector<double>& values, int count);

/// 1, 2 or 5 times a power of ten, so that the rms of `steps` becomes about a fortieth of `extent`: how much
/// to magnify residuals. 1 if there is nothing to see.
double RoundMagnification(const std::vector<Eigen::Vector2d>& steps, double extent);

/// Places of round ticks in [from, to], about `count` of them: 1, 2 or 5 times a power of ten, or, on a
/// logarithmic axis that has three of them, the decades' 1, 2, 5.
std::vector<double> Ticks(double from, double to, int count, bool logarithmic);

/// The drawing, one <svg> element of 480 x 320 units (same_scale: as high as its data ask for, within 200 to
/// 480). A plot without a finite value says so.
std::string PlotSvg(const Plot& plot);

}  // namespace adit::host
