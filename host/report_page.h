// The report of a tool: one page that a person reads and prints, and the same content as JSON.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/base/result.h"
#include "host/plot_svg.h"

namespace adit::host {

/// A text, or a number: rounded for people, whole for programs.
struct ReportCell {
  std::string text;             ///< as people read it
  std::optional<double> value;  ///< what JSON holds; empty: the text
};
ReportCell ReportNumber(double value, int decimals);
inline ReportCell ReportWords(std::string text) { return {std::move(text), std::nullopt}; }

struct ReportColumn {
  std::string key;    ///< in JSON, with the unit: rms_mm
  std::string title;  ///< above the column, with the unit
};

struct ReportTable {
  std::string key, caption;
  std::vector<ReportColumn> columns;
  std::vector<std::vector<ReportCell>> rows;
};

/// One figure that stands for itself: "baseline", 9.0002, "m".
struct ReportFact {
  std::string key, name;
  ReportCell cell;
  std::string unit;
};

enum class ReportVerdict { kGood, kCaution, kBad };

/// What a report holds, in the order of the calls. No heap limits, no threads: for workstations.
class ReportPage {
 public:
  /// `tool`: "train"; `title`: what the page is about; `origin`: files and times it came from.
  ReportPage(std::string tool, std::string title, std::string origin)
      : tool_(std::move(tool)), title_(std::move(title)), origin_(std::move(origin)) {}

  /// The verdict stands at the top; its reasons are sentences.
  void Verdict(ReportVerdict verdict, std::string sentence, std::vector<std::string> reasons = {});
  void Section(std::string title) { parts_.emplace_back(Heading{std::move(title)}); }
  void Paragraph(std::string text) { parts_.emplace_back(Sentence{std::move(text)}); }
  void Facts(std::vector<ReportFact> facts) { parts_.emplace_back(std::move(facts)); }
  void Add(ReportTable table) { parts_.emplace_back(std::move(table)); }
  void Add(Plot plot) { parts_.emplace_back(std::move(plot)); }

  /// Self-contained HTML 5: style and drawings inside, no scripts, nothing fetched.
  std::string Html() const;
  /// {tool, title, origin, verdict, sentence, reasons, parts: [{section}, {text}, {facts}, {key, rows},
  /// {title, series with all points}]}, in the order of the page.
  std::string Json() const;

 private:
  struct Heading {
    std::string text;
  };
  struct Sentence {
    std::string text;
  };
  using Part = std::variant<Heading, Sentence, std::vector<ReportFact>, ReportTable, Plot>;

  std::string tool_, title_, origin_;
  ReportVerdict verdict_ = ReportVerdict::kGood;
  std::string sentence_;
  std::vector<std::string> reasons_;
  std::vector<Part> parts_;
};

/// Where a command was told to put its report; empty: nowhere.
struct ReportFiles {
  std::string html, json;
};

/// Writes what was asked for, and `others` with it (what the report is about, first): all files or none.
base::Result<void> WriteReport(const ReportPage& page, const ReportFiles& files,
                               std::vector<linux::FileText> others = {});

}  // namespace adit::host
