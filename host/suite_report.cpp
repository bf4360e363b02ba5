#include "host/suite_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace adit::host {
namespace {

const char* Sign(SuiteFigure::Bar kind) { return kind == SuiteFigure::Bar::kAtMost ? "<=" : ">="; }

/// JSON knows no NaN.
std::string Number(double value) {
  if (!std::isfinite(value)) return "null";
  std::ostringstream text;
  text << std::setprecision(9) << value;
  return text.str();
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

void SuiteReport::AtMost(std::string what, double value, double bar, std::string unit, int decimals) {
  figures.push_back({std::move(what), std::move(unit), value, SuiteFigure::Bar::kAtMost, bar, decimals});
}

void SuiteReport::AtLeast(std::string what, double value, double bar, std::string unit, int decimals) {
  figures.push_back({std::move(what), std::move(unit), value, SuiteFigure::Bar::kAtLeast, bar, decimals});
}

void SuiteReport::Inform(std::string what, double value, std::string unit, int decimals) {
  figures.push_back({std::move(what), std::move(unit), value, SuiteFigure::Bar::kNoBar, 0, decimals});
}

bool SuiteReport::Holds() const {
  return std::all_of(figures.begin(), figures.end(), [](const SuiteFigure& f) { return f.Holds(); });
}

std::string FormatSuiteTable(const SuiteReport& report) {
  std::ostringstream text;
  text << report.name << ": " << report.how << "\n" << std::fixed;
  for (const SuiteFigure& f : report.figures) {
    text << "  " << std::left << std::setw(58) << f.what << std::right << std::setprecision(f.decimals)
         << std::setw(12) << f.value << " " << std::left << std::setw(3) << f.unit;
    if (f.kind != SuiteFigure::Bar::kNoBar)
      text << " " << Sign(f.kind) << " " << std::setw(9) << f.bar << (f.Holds() ? " holds" : " MISSED");
    text << "\n";
  }
  for (const std::string& finding : report.findings) text << "  ! " << finding << "\n";
  return text.str();
}

ReportPage MakeSuitePage(const std::vector<SuiteReport>& reports, const std::string& origin,
                         const std::string& caveat) {
  std::vector<std::string> missed;
  for (const SuiteReport& report : reports) {
    for (const SuiteFigure& f : report.figures) {
      if (!f.Holds()) missed.push_back(report.name + ": " + f.what);
    }
  }
  ReportPage page("evaluate", "Campaign in simulation", origin);
  page.Verdict(missed.empty() ? ReportVerdict::kGood : ReportVerdict::kBad,
               missed.empty() ? "Every bar holds." : "Missed:", missed);
  page.Paragraph(caveat);
  for (const SuiteReport& report : reports) {
    page.Section(report.name);
    ReportTable table{
        report.name,
        report.how,
        {{"what", "figure"}, {"value", "measured"}, {"unit", "unit"}, {"bar", "bar"}, {"holds", ""}},
        {}};
    for (const SuiteFigure& f : report.figures) {
      const bool judged = f.kind != SuiteFigure::Bar::kNoBar;
      const std::string bar = judged ? Sign(f.kind) + (" " + ReportNumber(f.bar, f.decimals).text) : "";
      table.rows.push_back({ReportWords(f.what), ReportNumber(f.value, f.decimals), ReportWords(f.unit),
                            ReportWords(bar), ReportWords(judged ? f.Holds() ? "holds" : "missed" : "")});
    }
    page.Add(std::move(table));
    for (const std::string& finding : report.findings) page.Paragraph(finding);
  }
  return page;
}

std::string FormatSuiteJson(const std::vector<SuiteReport>& reports, const std::string& suite,
                            std::uint64_t seed) {
  std::ostringstream text;
  text << "{\n  \"suite\": " << Quoted(suite) << ",\n  \"seed\": " << seed << ",\n  \"cases\": [";
  const char* separator = "\n";
  for (const SuiteReport& report : reports) {
    text << separator << "    {\"case\": " << Quoted(report.name) << ", \"how\": " << Quoted(report.how)
         << ", \"holds\": " << (report.Holds() ? "true" : "false") << ", \"figures\": [";
    const char* between = "\n";
    for (const SuiteFigure& f : report.figures) {
      text << between << "      {\"what\": " << Quoted(f.what) << ", \"value\": " << Number(f.value)
           << ", \"unit\": " << Quoted(f.unit);
      if (f.kind != SuiteFigure::Bar::kNoBar)
        text << ", \"" << (f.kind == SuiteFigure::Bar::kAtMost ? "at_most" : "at_least")
             << "\": " << Number(f.bar) << ", \"holds\": " << (f.Holds() ? "true" : "false");
      text << "}";
      between = ",\n";
    }
    text << "\n    ]}";
    separator = ",\n";
  }
  text << "\n  ]\n}\n";
  return text.str();
}

}  // namespace adit::host
