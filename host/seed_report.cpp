#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "host/report_text.h"
#include "host/seed_tables.h"

namespace adit::host {
namespace {

/// Three figures that matter.
int DecimalsOf(double value) { return value < 1 ? 3 : value < 100 ? 2 : 1; }
ReportCell FigureCell(double value) { return ReportNumber(value, DecimalsOf(std::abs(value))); }

std::string HowItStands(const SeedTable& table) {
  std::size_t limited = 0, held = 0;
  for (const SeedRow& row : table.rows) {
    for (const SeedCell& cell : row.cells)
      limited += cell.limit_name.empty() ? 0 : 1, held += !cell.limit_name.empty() && cell.Holds() ? 1 : 0;
  }
  return std::to_string(held) + " of " + std::to_string(limited) + " limits held; " +
         std::to_string(table.lost) + " of " + std::to_string(table.frames) + " frames lost";
}

ReportTable TableOf(const SeedTable& table) {
  ReportTable out{"table_" + table.number,
                  "Table " + table.number + ", mm: thesis, bound, adit",
                  {{"distance_m", "distance, m"}},
                  {}};
  const bool has_settings = !table.rows[0].setting.empty();
  if (has_settings) out.columns.push_back({"setting", ""});
  for (const SeedCell& cell : table.rows[0].cells) {
    out.columns.push_back({cell.key + "_thesis", cell.title + " thesis"});
    out.columns.push_back({cell.key + "_bound", "bound"});
    out.columns.push_back({cell.key, "adit"});
  }
  out.columns.push_back({"missed", "limits missed"});
  for (const SeedRow& row : table.rows) {
    std::vector<ReportCell> cells{ReportNumber(row.distance_m, 0)};
    if (has_settings) cells.push_back(ReportWords(row.setting));
    std::string missed;
    for (const SeedCell& cell : row.cells) {
      cells.insert(cells.end(),
                   {FigureCell(cell.thesis_mm), FigureCell(cell.bound_mm), FigureCell(cell.measured_mm)});
      if (!cell.Holds()) missed += (missed.empty() ? "" : ", ") + cell.title + ": " + cell.limit_name;
    }
    cells.push_back(ReportWords(missed.empty() ? "\u2013" : missed));
    out.rows.push_back(std::move(cells));
  }
  return out;
}

/// One plot for every column; one group of series for every setting.
std::vector<Plot> PlotsOf(const SeedTable& table) {
  std::vector<Plot> plots;
  for (std::size_t column = 0; column < table.rows[0].cells.size(); ++column) {
    const SeedCell& head = table.rows[0].cells[column];
    Plot plot;
    plot.title = "Table " + table.number + ": " + head.title;
    plot.x.label = "distance, m", plot.y.label = head.title + ", mm";
    plot.y.logarithmic = true;
    std::vector<std::string> settings;
    for (const SeedRow& row : table.rows) {
      if (std::find(settings.begin(), settings.end(), row.setting) == settings.end())
        settings.push_back(row.setting);
    }
    for (const std::string& setting : settings) {
      const std::string suffix = setting.empty() ? "" : ", " + setting;
      const bool is_first = setting == settings[0];
      PlotSeries thesis{"thesis" + suffix, is_first ? PlotMark::kCross : PlotMark::kTriangle, {}, {}};
      PlotSeries bound{"bound" + suffix, is_first ? PlotMark::kDashedLine : PlotMark::kDottedLine, {}, {}};
      PlotSeries adit{"adit" + suffix, is_first ? PlotMark::kDot : PlotMark::kRing, {}, {}};
      for (const SeedRow& row : table.rows) {
        if (row.setting != setting) continue;
        const SeedCell& cell = row.cells[column];
        thesis.points.emplace_back(row.distance_m, cell.thesis_mm);
        bound.points.emplace_back(row.distance_m, cell.bound_mm);
        adit.points.emplace_back(row.distance_m, cell.measured_mm);
      }
      if (std::isnan(thesis.points[0].y())) thesis.name.clear(), thesis.points.clear();
      plot.series.insert(plot.series.end(), {thesis, bound, adit});
    }
    plots.push_back(plot);
  }
  return plots;
}

}  // namespace

std::string FormatSeedTable(const SeedTable& table) {
  std::ostringstream text;
  text << "Table " << table.number << "  " << table.caption << "\n  " << table.how
       << "\n  distance_m              ";
  for (const SeedCell& cell : table.rows[0].cells) text << std::setw(24) << cell.key;
  text << "\n                          ";
  for (std::size_t i = 0; i < table.rows[0].cells.size(); ++i) text << "    thesis   bound    adit";
  text << "\n" << std::fixed;
  for (const SeedRow& row : table.rows) {
    text << std::setw(8) << std::setprecision(0) << row.distance_m << "  " << std::left << std::setw(16)
         << row.setting << std::right;
    for (const SeedCell& cell : row.cells) {
      text << "  ";
      for (const double value : {cell.thesis_mm, cell.bound_mm, cell.measured_mm}) {
        if (std::isnan(value))
          text << std::setw(8) << "-";
        else
          text << std::setw(8) << std::setprecision(DecimalsOf(value)) << value;
      }
    }
    for (const SeedCell& cell : row.cells) {
      if (!cell.Holds()) text << "  MISSED " << cell.key << ": " << cell.limit_name;
    }
    text << "\n";
  }
  text << "  " << HowItStands(table) << "\n";
  return text.str();
}

ReportPage MakeSeedReport(const std::vector<SeedTable>& tables, const SeedOrder& order) {
  ReportPage page("evaluate --suite seed", "The thesis' tables 5.1 to 5.6 in simulation",
                  "seed " + std::to_string(order.seed) + ", " + std::to_string(order.calibrations) +
                      " calibrations a rig");
  const bool holds =
      std::all_of(tables.begin(), tables.end(), [](const SeedTable& table) { return table.Holds(); });
  page.Verdict(holds ? ReportVerdict::kGood : ReportVerdict::kBad,
               holds ? "All limits hold, in simulation." : "Some limits are missed.", SeedCaveats(order));
  for (const SeedTable& table : tables) {
    page.Section("Table " + table.number + ": " + table.caption);
    page.Paragraph(table.how);
    page.Paragraph(HowItStands(table));
    page.Add(TableOf(table));
    for (Plot& plot : PlotsOf(table)) page.Add(std::move(plot));
  }
  return page;
}

}  // namespace adit::host
