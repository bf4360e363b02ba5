#include "host/intrinsics.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/board_image.h"
#include "host/failure.h"
#include "host/intrinsics_report.h"
#include "host/intrinsics_text.h"
#include "host/progress.h"

namespace adit::host {
namespace {

struct IntrinsicsArguments {
  std::vector<std::string> images;
  std::string board, charuco, out, coverage;
  ReportFiles report;
  double square_m = 0, marker_m = 0;
};

base::Result<Board> BoardOf(const IntrinsicsArguments& arguments) {
  auto board = ParseBoard(arguments.board, arguments.square_m);
  if (!board || arguments.charuco.empty()) return board;
  return WithMarkers(*board, arguments.charuco, arguments.marker_m);
}

/// What the images show of the board; all have one size.
struct BoardViews {
  std::vector<BoardView> views;
  cv::Size size_px;
};

base::Result<BoardViews> FindBoards(const IntrinsicsArguments& arguments, const Board& board) {
  const auto images = ListImages(arguments.images);
  if (!images) return images.error();
  BoardViews found;
  Progress progress("board", images->size());
  for (const std::string& path : *images) {
    const auto image = ReadBoardImage(path);
    if (!image) return image.error();
    if (found.views.empty()) found.size_px = image->size();
    if (image->size() != found.size_px) {
      const auto text = [](cv::Size size) {
        return std::to_string(size.width) + " x " + std::to_string(size.height) + " px";
      };
      return base::Error{base::ErrorCode::kMalformed, path,
                         "is " + text(image->size()) + ", but " + images->front() + " is " +
                             text(found.size_px) + "; the images of one camera have one size"};
    }
    found.views.push_back(FindBoard(board, path, *image));
    progress.Step();
  }
  return found;
}

int RunIntrinsics(const IntrinsicsArguments& arguments) {
  const char* const name = "intrinsics";
  const auto board = BoardOf(arguments);
  if (!board) return Fail(name, board.error());
  auto found = FindBoards(arguments, *board);
  if (!found) return Fail(name, found.error());
  const auto calibration =
      CalibrateIntrinsics(std::move(found->views), found->size_px.width, found->size_px.height);
  if (!calibration) return Fail(name, calibration.error());
  std::vector<linux::FileText> results{{arguments.out, FormatIntrinsics(*calibration)}};
  if (!arguments.coverage.empty()) {
    const auto png = DrawCoverage(calibration->Coverage(), calibration->marks,
                                  {found->size_px.width, found->size_px.height}, calibration->sigma0_px);
    results.push_back({arguments.coverage, std::string(png.begin(), png.end())});
  }
  if (auto written =
          WriteReport(MakeIntrinsicsReport(*calibration, *board), arguments.report, std::move(results));
      !written)
    return Fail(name, written.error());
  std::cout << Summary(*calibration, *board);
  return 0;
}

}  // namespace

void AddIntrinsics(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("intrinsics", "a camera file from images of a calibration board");
  auto arguments = std::make_shared<IntrinsicsArguments>();
  command->add_option("IMAGES", arguments->images, "image files, or folders of them")->required();
  command
      ->add_option("--board", arguments->board,
                   "corners inside the board, COLUMNSxROWS; 10 by 7 squares are 9x6, with markers or without")
      ->required();
  command->add_option("--square-m", arguments->square_m, "side of a square")
      ->required()
      ->check(CLI::Range(0.0001, 10.0));
  auto* charuco =
      command->add_option("--charuco", arguments->charuco,
                          "the board is a ChArUco board with markers of this dictionary (DICT_4X4_50)");
  auto* marker = command->add_option("--marker-m", arguments->marker_m, "side of its markers");
  charuco->needs(marker);
  marker->needs(charuco);
  command->add_option("--out", arguments->out, "sensor.yaml to write")->required();
  command->add_option("--coverage", arguments->coverage, "also draw corners and residuals into this PNG");
  command->add_option("--report", arguments->report.html, "also write a page with plots here");
  command->add_option("--json", arguments->report.json, "write the page's figures here");
  command->callback([arguments, &exit_code] { exit_code = RunIntrinsics(*arguments); });
}

}  // namespace adit::host
