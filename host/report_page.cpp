#include "host/report_page.h"

#include <sstream>
#include <utility>

#include "host/report_text.h"

namespace adit::host {
namespace {

// Paper first: black on white, tables that a pencil can tick, nothing split between two sheets.
constexpr const char* kPageStyle = R"(
:root{color-scheme:light}
body{font:15px/1.45 "Helvetica Neue",Arial,"Liberation Sans",sans-serif;color:#111;background:#fff;max-width:62em;
margin:2em auto;padding:0 1.5em}
header{border-bottom:3px solid #111;margin-bottom:1.2em}
header p{margin:.2em 0 .8em;color:#444}
h1{font-size:1.6em;margin:.1em 0}
h2{font-size:1.15em;margin:1.8em 0 .5em;border-bottom:1px solid #999;break-after:avoid}
.tool{font-size:.85em;letter-spacing:.08em;text-transform:uppercase;color:#444}
.verdict{border:2px solid #111;border-left-width:12px;padding:.6em 1em;margin:1em 0;break-inside:avoid}
.verdict.good{border-color:#1a7a5a}.verdict.caution{border-color:#b8860b}.verdict.bad{border-color:#a11}
.verdict b{display:block}.verdict ul{margin:.4em 0 0;padding-left:1.2em}
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(15em,1fr));gap:.15em 2em;margin:.6em 0}
dl div{display:flex;justify-content:space-between;border-bottom:1px dotted #aaa;gap:1em}
dt{color:#444}dd{margin:0;font-variant-numeric:tabular-nums;text-align:right;white-space:nowrap}
table{border-collapse:collapse;margin:.4em 0 1.2em;font-size:.92em;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:bold;padding:.2em 0}
th{border-top:2px solid #111;border-bottom:1px solid #111;text-align:right;vertical-align:bottom;font-weight:normal;
color:#333;padding:.2em .7em}
td{border-bottom:1px solid #ddd;padding:.15em .7em;text-align:right}
td.words,th.words{text-align:left}
tr{break-inside:avoid}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(25em,1fr));gap:1em 1.5em}
figure{margin:0;break-inside:avoid}
figcaption{font-weight:bold;font-size:.95em}
figure p{margin:.2em 0 0;font-size:.85em;color:#444}
svg{width:100%;height:auto;font:11px "Helvetica Neue",Arial,"Liberation Sans",sans-serif}
footer{margin-top:2em;border-top:1px solid #999;font-size:.8em;color:#555}
@media print{body{margin:0;max-width:none;font-size:10pt}*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}
@page{size:A4;margin:15mm}
)";

const char* VerdictName(ReportVerdict verdict) {
  return verdict == ReportVerdict::kGood ? "good" : verdict == ReportVerdict::kCaution ? "caution" : "bad";
}

void WriteTableHtml(const ReportTable& table, std::ostream& out) {
  out << "<table><caption>" << HtmlText(table.caption) << "</caption><thead><tr>";
  // A column is of words if its first row is.
  std::vector<const char*> kind;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const bool is_words = !table.rows.empty() && !table.rows[0][i].value;
    kind.push_back(is_words ? " class=\"words\"" : "");
    out << "<th" << kind[i] << ">" << HtmlText(table.columns[i].title) << "</th>";
  }
  out << "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    out << "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      out << "<td" << kind[i] << ">" << HtmlText(row[i].text) << "</td>";
    out << "</tr>\n";
  }
  out << "</tbody></table>\n";
}

void WriteFactsHtml(const std::vector<ReportFact>& facts, std::ostream& out) {
  out << "<dl>\n";
  for (const ReportFact& fact : facts) {
    out << "<div><dt>" << HtmlText(fact.name) << "</dt><dd>" << HtmlText(fact.cell.text)
        << (fact.unit.empty() ? "" : " ") << HtmlText(fact.unit) << "</dd></div>\n";
  }
  out << "</dl>\n";
}

void WritePlotHtml(const Plot& plot, std::ostream& out) {
  out << "<figure><figcaption>" << HtmlText(plot.title) << "</figcaption>" << PlotSvg(plot);
  if (!plot.note.empty()) out << "<p>" << HtmlText(plot.note) << "</p>";
  out << "</figure>\n";
}

std::string CellJson(const ReportCell& cell) {
  return cell.value ? JsonNumber(*cell.value) : JsonText(cell.text);
}

/// Items between commas.
class JsonList {
 public:
  explicit JsonList(std::ostream& out) : out_(out) {}
  std::ostream& Next() { return out_ << (std::exchange(is_first_, false) ? "" : ", "); }

 private:
  std::ostream& out_;
  bool is_first_ = true;
};

void WriteTableJson(const ReportTable& table, std::ostream& out) {
  out << "{\"key\": " << JsonText(table.key) << ", \"caption\": " << JsonText(table.caption)
      << ", \"rows\": [";
  JsonList rows(out);
  for (const auto& row : table.rows) {
    rows.Next() << "\n      {";
    JsonList cells(out);
    for (std::size_t i = 0; i < row.size(); ++i)
      cells.Next() << JsonText(table.columns[i].key) << ": " << CellJson(row[i]);
    out << "}";
  }
  out << "]}";
}

void WritePointsJson(const std::vector<Eigen::Vector2d>& points, std::ostream& out) {
  out << "[";
  JsonList list(out);
  for (const Eigen::Vector2d& point : points)
    list.Next() << "[" << JsonNumber(point.x()) << ", " << JsonNumber(point.y()) << "]";
  out << "]";
}

void WriteNumbersJson(const std::vector<double>& numbers, std::ostream& out) {
  out << "[";
  JsonList list(out);
  for (const double number : numbers) list.Next() << JsonNumber(number);
  out << "]";
}

void WritePlotJson(const Plot& plot, std::ostream& out) {
  out << "{\"title\": " << JsonText(plot.title) << ", \"x\": " << JsonText(plot.x.label)
      << ", \"y\": " << JsonText(plot.y.label) << ", \"series\": [";
  JsonList list(out);
  for (const PlotSeries& series : plot.series) {
    list.Next() << "\n      {\"name\": " << JsonText(series.name) << ", \"points\": ";
    WritePointsJson(series.points, out);
    out << ", \"sigma\": ";
    WriteNumbersJson(series.sigma, out);
    out << "}";
  }
  for (const PlotVectors& vectors : plot.vectors) {
    list.Next() << "\n      {\"name\": " << JsonText(vectors.name) << ", \"unit\": " << JsonText(vectors.unit)
                << ", \"places\": ";
    WritePointsJson(vectors.places, out);
    out << ", \"steps\": ";
    WritePointsJson(vectors.steps, out);
    out << "}";
  }
  for (const PlotHistogram& histogram : plot.histograms) {
    list.Next() << "\n      {\"name\": " << JsonText(histogram.name)
                << ", \"from\": " << JsonNumber(histogram.from)
                << ", \"width\": " << JsonNumber(histogram.width) << ", \"counts\": ";
    WriteNumbersJson(histogram.counts, out);
    out << "}";
  }
  for (const PlotCells& cells : plot.cells) {
    list.Next() << "\n      {\"name\": " << JsonText(cells.name) << ", \"columns\": " << cells.columns
                << ", \"rows\": " << cells.rows << ", \"values\": ";
    WriteNumbersJson(cells.values, out);
    out << "}";
  }
  out << "]}";
}

void WriteFactsJson(const std::vector<ReportFact>& facts, std::ostream& out) {
  out << "{\"facts\": {";
  JsonList list(out);
  for (const ReportFact& fact : facts) list.Next() << JsonText(fact.key) << ": " << CellJson(fact.cell);
  out << "}}";
}

}  // namespace

ReportCell ReportNumber(double value, int decimals) { return {ReadableNumber(value, decimals), value}; }

void ReportPage::Verdict(ReportVerdict verdict, std::string sentence, std::vector<std::string> reasons) {
  verdict_ = verdict;
  sentence_ = std::move(sentence);
  reasons_ = std::move(reasons);
}

std::string ReportPage::Html() const {
  std::ostringstream out;
  out << "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>adit " << HtmlText(tool_)
      << ": " << HtmlText(title_) << "</title><style>" << kPageStyle
      << "</style></head>\n<body><header><div class=\"tool\">adit " << HtmlText(tool_) << "</div><h1>"
      << HtmlText(title_) << "</h1><p>" << HtmlText(origin_) << "</p></header>\n";
  if (!sentence_.empty()) {
    out << "<div class=\"verdict " << VerdictName(verdict_) << "\"><b>" << HtmlText(sentence_) << "</b>";
    if (!reasons_.empty()) {
      out << "<ul>";
      for (const std::string& reason : reasons_) out << "<li>" << HtmlText(reason) << "</li>";
      out << "</ul>";
    }
    out << "</div>\n";
  }
  bool in_plots = false;  // plots that follow one another stand side by side
  for (const Part& part : parts_) {
    const auto* plot = std::get_if<Plot>(&part);
    if ((plot != nullptr) != in_plots) out << (plot != nullptr ? "<div class=\"plots\">\n" : "</div>\n");
    in_plots = plot != nullptr;
    if (plot != nullptr) WritePlotHtml(*plot, out);
    if (const auto* heading = std::get_if<Heading>(&part))
      out << "<h2>" << HtmlText(heading->text) << "</h2>\n";
    if (const auto* text = std::get_if<Sentence>(&part)) out << "<p>" << HtmlText(text->text) << "</p>\n";
    if (const auto* facts = std::get_if<std::vector<ReportFact>>(&part)) WriteFactsHtml(*facts, out);
    if (const auto* table = std::get_if<ReportTable>(&part)) WriteTableHtml(*table, out);
  }
  out << (in_plots ? "</div>\n" : "") << "<footer>adit " << HtmlText(tool_)
      << "; one standard deviation unless said otherwise; the same figures as JSON with "
         "--json.</footer></body></html>\n";
  return out.str();
}

std::string ReportPage::Json() const {
  std::ostringstream out;
  out << "{\n  \"tool\": " << JsonText(tool_) << ",\n  \"title\": " << JsonText(title_)
      << ",\n  \"origin\": " << JsonText(origin_) << ",\n  \"verdict\": " << JsonText(VerdictName(verdict_))
      << ",\n  \"sentence\": " << JsonText(sentence_) << ",\n  \"reasons\": [";
  JsonList reasons(out);
  for (const std::string& reason : reasons_) reasons.Next() << JsonText(reason);
  out << "],\n  \"parts\": [";
  JsonList list(out);
  for (const Part& part : parts_) {
    list.Next() << "\n    ";
    if (const auto* heading = std::get_if<Heading>(&part))
      out << "{\"section\": " << JsonText(heading->text) << "}";
    if (const auto* text = std::get_if<Sentence>(&part)) out << "{\"text\": " << JsonText(text->text) << "}";
    if (const auto* facts = std::get_if<std::vector<ReportFact>>(&part)) WriteFactsJson(*facts, out);
    if (const auto* table = std::get_if<ReportTable>(&part)) WriteTableJson(*table, out);
    if (const auto* plot = std::get_if<Plot>(&part)) WritePlotJson(*plot, out);
  }
  out << "\n  ]\n}\n";
  return out.str();
}

base::Result<void> WriteReport(const ReportPage& page, const ReportFiles& files,
                               std::vector<linux::FileText> others) {
  if (!files.html.empty()) others.push_back({files.html, page.Html()});
  if (!files.json.empty()) others.push_back({files.json, page.Json()});
  return linux::WriteFilesAtomically(others);
}

}  // namespace adit::host
