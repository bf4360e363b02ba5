#include "host/report_page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "host/report_text.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::HistogramOf;
using adit::host::HtmlText;
using adit::host::JsonNumber;
using adit::host::JsonText;
using adit::host::Plot;
using adit::host::PlotMark;
using adit::host::PlotSvg;
using adit::host::ReadableNumber;
using adit::host::ReportNumber;
using adit::host::ReportPage;
using adit::host::ReportVerdict;
using adit::host::ReportWords;
using adit::host::Ticks;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::size_t CountOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// Every tag that opens is closed by its own name, in order; void ones and those closed in place aside.
bool IsWellFormed(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = html.substr(at + 1, end - at - 1);
    if (tag[0] == '!' || tag.back() == '/' || tag.starts_with("meta")) continue;
    if (tag[0] != '/') {
      open.push_back(tag.substr(0, tag.find(' ')));
    } else {
      if (open.empty() || open.back() != tag.substr(1)) return false;
      open.pop_back();
    }
  }
  return open.empty();
}

Plot OnePlot() {
  Plot plot;
  plot.title = "residuals <left>";
  plot.x.label = "u, px", plot.y.label = "v, px";
  plot.series.push_back({"measured", PlotMark::kRing, {{1, 2}, {3, 4}, {kNan, 5}}, {0.5, 0.25, 1}});
  plot.vectors.push_back({"residual", "px", 50, {{1, 2}}, {{0.01, 0}}});
  return plot;
}

ReportPage OnePage() {
  ReportPage page("train", "Model of 'a<b>'", "rec & more");
  page.Verdict(ReportVerdict::kCaution, "usable, but:", {"one \"reason\""});
  page.Section("Figures");
  page.Paragraph("text");
  page.Facts({{"baseline_m", "baseline", ReportNumber(9.00024, 3), "m"}});
  page.Add({"points",
            "Points",
            {{"name", "point"}, {"rms_mm", "rms, mm"}},
            {{ReportWords("P1"), ReportNumber(-1.25, 1)}, {ReportWords("<i>"), ReportNumber(kNan, 1)}}});
  page.Add(OnePlot());
  page.Add(OnePlot());
  return page;
}

}  // namespace

TEST_GROUP(ReportPage){};

TEST(ReportPage, EscapesWhatComesFromFiles) {
  STRCMP_EQUAL("&lt;b&gt; &amp; &quot;x&quot; &#39;", HtmlText("<b> & \"x\" '").c_str());
  STRCMP_EQUAL("\"a\\\"b\\\\c\\n\\u0001\"", JsonText("a\"b\\c\n\x01").c_str());
}

TEST(ReportPage, WritesNumbersForPeopleAndForPrograms) {
  STRCMP_EQUAL("\u22121.3", ReadableNumber(-1.26, 1).c_str());
  STRCMP_EQUAL("0.0", ReadableNumber(-0.001, 1).c_str());
  STRCMP_EQUAL("\u2013", ReadableNumber(kNan, 2).c_str());
  STRCMP_EQUAL("0.123456789", JsonNumber(0.123456789).c_str());
  STRCMP_EQUAL("null", JsonNumber(INFINITY).c_str());
}

TEST(ReportPage, IsOneWellFormedPageThatFetchesNothing) {
  const std::string html = OnePage().Html();
  CHECK(IsWellFormed(html));
  CHECK_FALSE(Has(html, "<script"));
  CHECK_FALSE(Has(html, "http"));
  CHECK_FALSE(Has(html, "src="));
  CHECK_FALSE(Has(html, "<b>'"));
  CHECK(Has(html, "Model of &#39;a&lt;b&gt;&#39;"));
  CHECK(Has(html, "<td>\u22121.3</td>") || Has(html, "<td>\u22121.2</td>"));
  LONGS_EQUAL(2, CountOf(html, "<svg "));
}

TEST(ReportPage, HoldsTheSameInJson) {
  const std::string json = OnePage().Json();
  LONGS_EQUAL(CountOf(json, "{"), CountOf(json, "}"));
  LONGS_EQUAL(CountOf(json, "["), CountOf(json, "]"));
  CHECK(Has(json, "\"baseline_m\": 9.00024"));
  CHECK(Has(json, "{\"name\": \"P1\", \"rms_mm\": -1.25}"));
  CHECK(Has(json, "{\"name\": \"<i>\", \"rms_mm\": null}"));
  CHECK(Has(json, "[[1, 2], [3, 4], [null, 5]]"));
  CHECK(Has(json, "\"reasons\": [\"one \\\"reason\\\"\"]"));
}

TEST(ReportPage, PutsTicksOnRoundNumbers) {
  const auto plain = Ticks(0.013, 0.98, 6, false);
  LONGS_EQUAL(4, plain.size());
  DOUBLES_EQUAL(0.2, plain.front(), 1e-12);
  DOUBLES_EQUAL(0.8, plain.back(), 1e-12);
  const auto logarithmic = Ticks(4, 110, 6, true);
  LONGS_EQUAL(5, logarithmic.size());
  DOUBLES_EQUAL(5, logarithmic.front(), 1e-9);
  DOUBLES_EQUAL(100, logarithmic.back(), 1e-9);
  const auto narrow = Ticks(1.3, 4.7, 6, true);  // within a decade: only 2 is among 1, 2, 5
  LONGS_EQUAL(3, narrow.size());
  DOUBLES_EQUAL(2, narrow.front(), 1e-9);
}

TEST(ReportPage, MagnifiesByRoundFactors) {
  DOUBLES_EQUAL(2000, adit::host::RoundMagnification({{0.01, 0}, {0, 0.01}}, 1000), 1e-9);
  DOUBLES_EQUAL(5, adit::host::RoundMagnification({{3, 0}}, 1000), 1e-9);
  DOUBLES_EQUAL(1, adit::host::RoundMagnification({{0, 0}}, 1000), 0);
  DOUBLES_EQUAL(1, adit::host::RoundMagnification({}, 1000), 0);
}

TEST(ReportPage, CountsIntoClasses) {
  const auto histogram = HistogramOf("x", {0, 0.1, 0.95, 1, kNan}, 2);
  DOUBLES_EQUAL(0, histogram.from, 0);
  DOUBLES_EQUAL(0.5, histogram.width, 1e-12);
  DOUBLES_EQUAL(2, histogram.counts[0], 0);
  DOUBLES_EQUAL(2, histogram.counts[1], 0);
}

TEST(ReportPage, DrawsOneMarkAPointAndLeavesOutWhatIsNotFinite) {
  const std::string svg = PlotSvg(OnePlot());
  CHECK(IsWellFormed(svg));
  LONGS_EQUAL(4, CountOf(svg, "<circle"));  // two points, the foot of the vector, the legend
  CHECK_FALSE(Has(svg, "nan"));
  CHECK(Has(svg, "residuals &lt;left&gt;"));
}

TEST(ReportPage, SaysWhenThereIsNothingToDraw) {
  CHECK(Has(PlotSvg({}), "nothing to draw"));
  Plot single = OnePlot();
  single.series[0].points = {{5, 5}}, single.vectors.clear();
  CHECK_FALSE(Has(PlotSvg(single), "nan"));
  CHECK_FALSE(Has(PlotSvg(single), "inf"));
}

TEST(ReportPage, ShowsArrowsToTheirTips) {
  Plot plot;
  plot.vectors.push_back({"residual", "m", 50, {{0, 0}, {1, 0}}, {{0.02, 0}, {0.04, 0.01}}});
  const std::string svg = PlotSvg(plot);
  const auto after = [&svg](const char* key, std::size_t from) {
    return std::stod(svg.substr(svg.find(key, from) + std::string(key).size()));
  };
  const std::size_t frame = svg.find("<rect ");
  const double right = after("x=\"", frame) + after("width=\"", frame);
  double farthest = 0;
  for (std::size_t at = svg.find("x2=\""); at != std::string::npos; at = svg.find("x2=\"", at + 1))
    farthest = std::max(farthest, after("x2=\"", at));
  CHECK_COMPARE(farthest, <=, right);
}

// A metre must be as long to the right as upwards: a square of points stays one.
TEST(ReportPage, KeepsOneScaleOnMaps) {
  Plot map;
  map.same_scale = true;
  map.series.push_back({"", PlotMark::kDot, {{0, 0}, {10, 0}, {0, 10}}, {}});
  const std::string svg = PlotSvg(map);
  std::vector<std::pair<double, double>> places;
  for (std::size_t at = svg.find("cx=\""); at != std::string::npos; at = svg.find("cx=\"", at + 1))
    places.emplace_back(std::stod(svg.substr(at + 4)), std::stod(svg.substr(svg.find("cy=\"", at) + 4)));
  LONGS_EQUAL(3, places.size());
  DOUBLES_EQUAL(places[1].first - places[0].first, places[0].second - places[2].second, 0.1);
}

// A rig file without the page that it was to be judged by is half a result.
TEST(ReportPage, IsWrittenWithWhatItIsAboutOrNotAtAll) {
  namespace fs = std::filesystem;
  std::string name = (fs::temp_directory_path() / "adit-report-XXXXXX").string();
  CHECK(mkdtemp(name.data()) != nullptr);
  const fs::path folder = name;
  const ReportPage page("calibrate", "a rig", "a recording");
  const std::string rig = folder / "rig.yaml", html = folder / "page.html";
  CHECK_FALSE(WriteReport(page, {html, folder / "missing" / "page.json"}, {{rig, "rig"}}));
  CHECK(fs::is_empty(folder));
  CHECK_FALSE(WriteReport(page, {rig, ""}, {{rig, "rig"}}));
  CHECK(fs::is_empty(folder));
  CHECK(!!WriteReport(page, {html, folder / "page.json"}, {{rig, "rig"}}));
  CHECK(fs::exists(rig) && fs::exists(html) && fs::exists(folder / "page.json"));
  fs::remove_all(folder);
}
