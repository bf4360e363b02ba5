#include "host/plot_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "host/report_text.h"

namespace adit::host {
namespace {

using Eigen::Vector2d;

// Margins leave room for tick labels (left), the title (top) and the axis' name (bottom).
constexpr double kPlotWidth = 480, kPlotHeight = 320, kLowestPlot = 200, kHighestPlot = 480;
constexpr double kLeftMargin = 56, kRightMargin = 14, kTopMargin = 14, kBottomMargin = 44, kLegendLine = 15;
constexpr double kAxisPad = 0.04;  // of the data's span, at either end: no mark lies on the frame
// Dark enough to differ from paper in grey, and from each other in colour (Okabe & Ito 2008).
constexpr std::array<const char*, 5> kInks{"#0b3c6f", "#b3450b", "#1a7a5a", "#7a3b79", "#444444"};

struct PlotSpan {
  double low = INFINITY, high = -INFINITY;
  void Include(double value) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
  bool IsEmpty() const { return !(low <= high); }
};

/// One axis from data to drawing units.
class PlotScale {
 public:
  PlotScale(const PlotAxis& axis, PlotSpan span, double from_unit, double to_unit)
      : logarithmic_(axis.logarithmic), from_unit_(from_unit), to_unit_(to_unit) {
    if (axis.range) span = {axis.range->first, axis.range->second};
    if (!(span.high > span.low)) {
      const double pad = span.low == 0 ? 1 : 0.1 * std::abs(span.low);
      span = {span.low - pad, span.high + pad};
    } else if (!axis.range && logarithmic_) {
      const double pad = std::pow(span.high / span.low, kAxisPad);
      span = {span.low / pad, span.high * pad};
    } else if (!axis.range) {
      const double pad = kAxisPad * (span.high - span.low);
      span = {span.low == 0 ? 0 : span.low - pad, span.high + pad};
    }
    low = span.low, high = span.high;
    if (axis.reversed) std::swap(from_unit_, to_unit_);
  }

  double At(double value) const {
    const double share =
        logarithmic_ ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return from_unit_ + share * (to_unit_ - from_unit_);
  }
  bool Holds(double value) const {
    const double slack = 1e-9 * (high - low);
    return value >= low - slack && value <= high + slack;
  }
  std::vector<double> RoundPlaces(int count) const { return Ticks(low, high, count, logarithmic_); }

  double low = 0, high = 1;

 private:
  bool logarithmic_;
  double from_unit_, to_unit_;
};

std::string TickText(double value) {
  std::ostringstream text;
  text.precision(6);
  text << (std::abs(value) < 1e-12 ? 0.0 : value);
  return text.str();
}

class PlotDrawing {
 public:
  explicit PlotDrawing(const Plot& plot) : plot_(plot) {
    text_.precision(5);
    Measure();
  }

  std::string Draw() {
    if (x_span_.IsEmpty() || y_span_.IsEmpty()) return Empty();
    const double legend = kLegendLine * static_cast<double>(LegendNames());
    double inner_height = kPlotHeight - kTopMargin - kBottomMargin;
    const double inner_width = kPlotWidth - kLeftMargin - kRightMargin;
    if (plot_.same_scale) inner_height = FitScales(inner_width);
    const double height = inner_height + kTopMargin + kBottomMargin + legend;
    const PlotScale x(plot_.x, x_span_, kLeftMargin, kPlotWidth - kRightMargin);
    const PlotScale y(plot_.y, y_span_, kTopMargin + inner_height, kTopMargin);
    text_ << "<svg viewBox=\"0 0 " << kPlotWidth << " " << height << "\" role=\"img\" aria-label=\""
          << HtmlText(plot_.title) << "\">"
          << "<defs><pattern id=\"none\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" "
             "patternTransform=\"rotate(45)\"><line x1=\"0\" y1=\"0\" x2=\"0\" y2=\"7\" "
             "stroke=\"#999\"/></pattern></defs>";
    DrawFrame(x, y, kTopMargin + inner_height);
    for (const PlotCells& cells : plot_.cells) DrawCells(cells, x, y);
    for (const PlotHistogram& histogram : plot_.histograms) DrawHistogram(histogram, x, y);
    for (const PlotSeries& series : plot_.series) DrawSeries(series, x, y);
    for (const PlotVectors& vectors : plot_.vectors) DrawVectors(vectors, x, y);
    DrawLegend(kTopMargin + inner_height + kBottomMargin);
    text_ << "</svg>";
    return text_.str();
  }

 private:
  void Measure() {
    for (const PlotSeries& series : plot_.series) {
      for (std::size_t i = 0; i < series.points.size(); ++i) {
        const double sigma = i < series.sigma.size() ? series.sigma[i] : 0;
        Include(series.points[i] + Vector2d(0, sigma));
        Include(series.points[i] - Vector2d(0, sigma));
      }
    }
    for (const PlotVectors& vectors : plot_.vectors) {
      for (std::size_t i = 0; i < vectors.places.size(); ++i) {
        Include(vectors.places[i]);
        Include(vectors.places[i] + vectors.magnified * vectors.steps[i]);
      }
    }
    for (const PlotHistogram& histogram : plot_.histograms) {
      for (std::size_t i = 0; i < histogram.counts.size(); ++i)
        Include({histogram.from + histogram.width * static_cast<double>(i), histogram.counts[i]});
      Include({histogram.from + histogram.width * static_cast<double>(histogram.counts.size()), 0});
    }
    for (const PlotCells& cells : plot_.cells) Include(cells.low), Include(cells.high);
    if (plot_.x.range) x_span_ = {plot_.x.range->first, plot_.x.range->second};
    if (plot_.y.range) y_span_ = {plot_.y.range->first, plot_.y.range->second};
  }
  void Include(const Vector2d& point) {
    if ((plot_.x.logarithmic && !(point.x() > 0)) || (plot_.y.logarithmic && !(point.y() > 0))) return;
    if (!point.allFinite()) return;
    x_span_.Include(point.x()), y_span_.Include(point.y());
  }

  /// Widens one span so that both axes have one scale; the height that this takes.
  double FitScales(double inner_width) {
    const double wide = std::max(x_span_.high - x_span_.low, 1e-9);
    const double tall = std::max(y_span_.high - y_span_.low, 1e-9);
    const double border = kTopMargin + kBottomMargin;
    const double height = std::clamp(inner_width * tall / wide, kLowestPlot - border, kHighestPlot - border);
    const double per_unit = std::max(wide / inner_width, tall / height);
    const auto widen = [](PlotSpan& span, double to) {
      const double pad = 0.5 * (to - (span.high - span.low));
      span.low -= pad, span.high += pad;
    };
    widen(x_span_, per_unit * inner_width);
    widen(y_span_, per_unit * height);
    return height;
  }

  std::string Empty() {
    text_ << "<svg viewBox=\"0 0 " << kPlotWidth << " 60\"><text x=\"" << kPlotWidth / 2
          << "\" y=\"34\" text-anchor=\"middle\">nothing to draw</text></svg>";
    return text_.str();
  }

  void DrawFrame(const PlotScale& x, const PlotScale& y, double bottom) {
    const double right = kPlotWidth - kRightMargin;
    const char* const grid = "\" stroke=\"#ccc\" stroke-width=\"0.6\"/>";
    for (const double tick : x.RoundPlaces(7)) {
      text_ << "<line x1=\"" << x.At(tick) << "\" y1=\"" << kTopMargin << "\" x2=\"" << x.At(tick)
            << "\" y2=\"" << bottom << grid << "<text x=\"" << x.At(tick) << "\" y=\"" << bottom + 14
            << "\" text-anchor=\"middle\">" << TickText(tick) << "</text>";
    }
    for (const double tick : y.RoundPlaces(6)) {
      text_ << "<line x1=\"" << kLeftMargin << "\" y1=\"" << y.At(tick) << "\" x2=\"" << right << "\" y2=\""
            << y.At(tick) << grid << "<text x=\"" << kLeftMargin - 5 << "\" y=\"" << y.At(tick) + 3.5
            << "\" text-anchor=\"end\">" << TickText(tick) << "</text>";
    }
    text_ << "<rect x=\"" << kLeftMargin << "\" y=\"" << kTopMargin << "\" width=\"" << right - kLeftMargin
          << "\" height=\"" << bottom - kTopMargin << "\" fill=\"none\" stroke=\"#333\"/>"
          << "<text x=\"" << (kLeftMargin + right) / 2 << "\" y=\"" << bottom + 32
          << "\" text-anchor=\"middle\">" << HtmlText(plot_.x.label)
          << "</text><text transform=\"translate(13," << (kTopMargin + bottom) / 2
          << ") rotate(-90)\" text-anchor=\"middle\">" << HtmlText(plot_.y.label) << "</text>";
  }

  void DrawCells(const PlotCells& cells, const PlotScale& x, const PlotScale& y) {
    double most = 0;
    for (const double value : cells.values) most = std::max(most, std::isfinite(value) ? value : 0);
    for (int row = 0; row < cells.rows; ++row) {
      for (int column = 0; column < cells.columns; ++column) {
        const double value = cells.values[static_cast<std::size_t>(row * cells.columns + column)];
        const auto corner = [&](int c, int r) {
          const Vector2d share(static_cast<double>(c) / cells.columns, static_cast<double>(r) / cells.rows);
          const Vector2d place = cells.low + share.cwiseProduct(cells.high - cells.low);
          return Vector2d(x.At(place.x()), y.At(place.y()));
        };
        DrawCell(value, most, corner(column, row), corner(column + 1, row + 1));
      }
    }
  }
  void DrawCell(double value, double most, const Vector2d& a, const Vector2d& b) {
    const Vector2d low = a.cwiseMin(b), size = (a - b).cwiseAbs();
    const bool is_empty = !(value > 0);
    // Light to dark: white paper means little, as in print.
    const double darkness = is_empty ? 0 : 0.12 + 0.6 * std::sqrt(value / most);
    const int grey = static_cast<int>(std::lround(255 * (1 - darkness)));
    text_ << "<rect x=\"" << low.x() << "\" y=\"" << low.y() << "\" width=\"" << size.x() << "\" height=\""
          << size.y() << "\" stroke=\"#fff\" fill=\"";
    if (is_empty)
      text_ << "url(#none)\"/>";
    else
      text_ << "rgb(" << grey * 3 / 4 << "," << grey * 9 / 10 << "," << grey << ")\"/>";
    text_ << "<text x=\"" << low.x() + size.x() / 2 << "\" y=\"" << low.y() + size.y() / 2 + 3.5
          << "\" text-anchor=\"middle\" font-size=\"9\" fill=\"" << (darkness > 0.45 ? "#fff" : "#222")
          << "\">" << (is_empty ? "0" : TickText(std::round(value))) << "</text>";
  }

  void DrawHistogram(const PlotHistogram& histogram, const PlotScale& x, const PlotScale& y) {
    const char* ink = InkOf(histogram.name);
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
      if (!(histogram.counts[i] > 0)) continue;
      const double from = x.At(histogram.from + histogram.width * static_cast<double>(i));
      const double to = x.At(histogram.from + histogram.width * static_cast<double>(i + 1));
      const double top = y.At(histogram.counts[i]), bottom = y.At(std::max(0.0, y.low));
      text_ << "<rect x=\"" << from << "\" y=\"" << top << "\" width=\"" << to - from << "\" height=\""
            << bottom - top << "\" fill=\"" << ink << "\" fill-opacity=\"0.45\" stroke=\"" << ink << "\"/>";
    }
    AddLegend(histogram.name, ink, PlotMark::kSquare);
  }

  void DrawSeries(const PlotSeries& series, const PlotScale& x, const PlotScale& y) {
    const char* ink = InkOf(series.name);
    const bool is_line = series.mark >= PlotMark::kLine;
    if (is_line) text_ << "<polyline fill=\"none\" " << LineStyle(series.mark, ink) << " points=\"";
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      const Vector2d& point = series.points[i];
      if (!point.allFinite() || !x.Holds(point.x()) || !y.Holds(point.y())) continue;
      const Vector2d at(x.At(point.x()), y.At(point.y()));
      if (is_line) {
        text_ << at.x() << "," << at.y() << " ";
        continue;
      }
      if (i < series.sigma.size() && series.sigma[i] > 0) {
        const double top = std::min(y.high, point.y() + series.sigma[i]);
        const double bottom = std::max(y.low, point.y() - series.sigma[i]);
        text_ << "<line x1=\"" << at.x() << "\" x2=\"" << at.x() << "\" y1=\"" << y.At(top) << "\" y2=\""
              << y.At(bottom) << "\" stroke=\"" << ink << "\"/>";
      }
      DrawMark(series.mark, at, ink, series.points.size() > 300 ? 1.4 : 2.6);
    }
    if (is_line) text_ << "\"/>";
    AddLegend(series.name, ink, series.mark);
  }

  static std::string LineStyle(PlotMark mark, const char* ink) {
    const std::string dash = mark == PlotMark::kDashedLine   ? " stroke-dasharray=\"7 4\""
                             : mark == PlotMark::kDottedLine ? " stroke-dasharray=\"2 3\""
                                                             : "";
    return std::string("stroke-width=\"1.4\" stroke=\"") + ink + "\"" + dash;
  }

  void DrawMark(PlotMark mark, const Vector2d& at, const char* ink, double r) {
    const std::string fill = std::string("\" fill=\"") + ink + "\"/>";
    const std::string outline = std::string("\" fill=\"none\" stroke=\"") + ink + "\"/>";
    if (mark == PlotMark::kDot || mark == PlotMark::kRing) {
      text_ << "<circle cx=\"" << at.x() << "\" cy=\"" << at.y() << "\" r=\"" << r
            << (mark == PlotMark::kDot ? fill : outline);
    } else if (mark == PlotMark::kSquare) {
      text_ << "<rect x=\"" << at.x() - r << "\" y=\"" << at.y() - r << "\" width=\"" << 2 * r
            << "\" height=\"" << 2 * r << fill;
    } else if (mark == PlotMark::kTriangle) {
      text_ << "<path d=\"M" << at.x() << " " << at.y() - 1.3 * r << "l" << 1.2 * r << " " << 2.2 * r << "h"
            << -2.4 * r << "z" << outline;
    } else {
      text_ << "<path d=\"M" << at.x() - r << " " << at.y() - r << "l" << 2 * r << " " << 2 * r << "m0 "
            << -2 * r << "l" << -2 * r << " " << 2 * r << outline;
    }
  }

  void DrawVectors(const PlotVectors& vectors, const PlotScale& x, const PlotScale& y) {
    const char* ink = InkOf(vectors.name);
    for (std::size_t i = 0; i < vectors.places.size(); ++i) {
      const Vector2d from = vectors.places[i], to = from + vectors.magnified * vectors.steps[i];
      if (!from.allFinite() || !to.allFinite() || !x.Holds(from.x()) || !y.Holds(from.y())) continue;
      text_ << "<line x1=\"" << x.At(from.x()) << "\" y1=\"" << y.At(from.y()) << "\" x2=\"" << x.At(to.x())
            << "\" y2=\"" << y.At(to.y()) << "\" stroke=\"" << ink << "\"/>";
      DrawMark(PlotMark::kDot, {x.At(from.x()), y.At(from.y())}, ink, 1.2);
    }
    std::ostringstream name;
    name << vectors.name << " (" << vectors.magnified << " times longer"
         << ", dot: where measured)";
    AddLegend(name.str(), ink, PlotMark::kLine);
  }

  /// What has no name belongs to what stands before it.
  const char* InkOf(const std::string& name) {
    if (!name.empty() || inks_ == 0) ++inks_;
    return kInks[(inks_ - 1) % kInks.size()];
  }
  std::size_t LegendNames() const {
    const auto named = [](const auto& list) {
      return static_cast<std::size_t>(
          std::count_if(list.begin(), list.end(), [](const auto& item) { return !item.name.empty(); }));
    };
    return named(plot_.series) + named(plot_.histograms) + named(plot_.vectors);
  }
  void AddLegend(const std::string& name, const char* ink, PlotMark mark) {
    if (!name.empty()) legend_entries_.push_back({name, ink, mark});
  }
  void DrawLegend(double top) {
    for (const auto& entry : legend_entries_) {
      const Vector2d at(kLeftMargin + 14, top);
      if (entry.mark >= PlotMark::kLine) {
        text_ << "<line x1=\"" << at.x() - 12 << "\" x2=\"" << at.x() + 12 << "\" y1=\"" << at.y()
              << "\" y2=\"" << at.y() << "\" " << LineStyle(entry.mark, entry.ink) << "/>";
      } else {
        DrawMark(entry.mark, at, entry.ink, 3);
      }
      text_ << "<text x=\"" << at.x() + 20 << "\" y=\"" << at.y() + 3.5 << "\">" << HtmlText(entry.name)
            << "</text>";
      top += kLegendLine;
    }
  }

  struct LegendEntry {
    std::string name;
    const char* ink;
    PlotMark mark;
  };
  const Plot& plot_;
  PlotSpan x_span_, y_span_;
  std::ostringstream text_;
  std::vector<LegendEntry> legend_entries_;
  std::size_t inks_ = 0;
};

}  // namespace

PlotHistogram HistogramOf(const std::string& name, const std::vector<double>& values, int count) {
  PlotSpan span;
  for (const double value : values) span.Include(value);
  PlotHistogram histogram{name, 0, 1, std::vector<double>(static_cast<std::size_t>(count), 0)};
  if (span.IsEmpty()) return histogram;
  histogram.from = span.low;
  histogram.width = span.high > span.low ? (span.high - span.low) / count : 1;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    const int bin = static_cast<int>((value - span.low) / histogram.width);
    ++histogram.counts[static_cast<std::size_t>(std::clamp(bin, 0, count - 1))];
  }
  return histogram;
}

double RoundMagnification(const std::vector<Vector2d>& steps, double extent) {
  double squares = 0;
  for (const Vector2d& step : steps) squares += step.allFinite() ? step.squaredNorm() : 0;
  if (!(squares > 0)) return 1;
  const double wanted = extent / 40 / std::sqrt(squares / static_cast<double>(steps.size()));
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= wanted) return digit * power;
  }
  return power;
}

std::vector<double> Ticks(double from, double to, int count, bool logarithmic) {
  std::vector<double> ticks;
  const double slack = 1e-9 * (to - from);
  if (logarithmic) {
    for (double decade = std::pow(10, std::floor(std::log10(from))); decade <= to; decade *= 10) {
      for (const double step : {1.0, 2.0, 5.0}) {
        if (step * decade >= from - slack && step * decade <= to + slack) ticks.push_back(step * decade);
      }
    }
    // Over less than a decade these may be one or none: then the round places of a plain axis.
    constexpr std::size_t kEnough = 3;
    if (ticks.size() >= kEnough) return ticks;
    ticks.clear();
  }
  const double rough = (to - from) / count, power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double digit : {5.0, 2.0, 1.0}) {
    if (digit * power >= rough) step = digit * power;
  }
  for (double i = std::ceil((from - slack) / step); i * step <= to + slack; ++i) ticks.push_back(i * step);
  return ticks;
}

std::string PlotSvg(const Plot& plot) { return PlotDrawing(plot).Draw(); }

}  // namespace adit::host
