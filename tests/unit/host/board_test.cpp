#include "host/board.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Board;
using adit::host::ParseBoard;
using adit::host::WithMarkers;

}  // namespace

TEST_GROUP(Board){};

TEST(Board, CountsCornersAlongItsRows) {
  const auto board = ParseBoard("9x6", 0.04);

  LONGS_EQUAL(54, board->Corners());
  DOUBLES_EQUAL(0.08, board->CornerM(11).x(), 1e-15);
  DOUBLES_EQUAL(0.04, board->CornerM(11).y(), 1e-15);
}

TEST(Board, RefusesWhatIsNoCountOfCorners) {
  for (const char* text : {"", "9", "9x", "x6", "9x2", "2x9", "101x6", "9x6x", "9 by 6", "-9x6", "9x6 "}) {
    const auto board = ParseBoard(text, 0.04);
    CHECK_FALSE(board.operator bool());
    LONGS_EQUAL(2, board.error().ExitCode());
    STRCMP_CONTAINS(("'" + std::string(text) + "'").c_str(), board.error().detail.c_str());
  }
}

TEST(Board, RefusesMarkersThatCannotBe) {
  const Board board = *ParseBoard("9x6", 0.04);

  CHECK(WithMarkers(board, "DICT_4X4_50", 0.03)->markers.has_value());
  STRCMP_EQUAL("--charuco", WithMarkers(board, "DICT_9X9_50", 0.03).error().where.c_str());
  STRCMP_EQUAL("--marker-m", WithMarkers(board, "DICT_4X4_50", 0.04).error().where.c_str());
  STRCMP_EQUAL("--marker-m", WithMarkers(board, "DICT_4X4_50", 0).error().where.c_str());
  const auto large = WithMarkers(*ParseBoard("14x9", 0.04), "DICT_4X4_50", 0.03);
  STRCMP_CONTAINS("50 markers; the board's white squares need 75", large.error().detail.c_str());
}
