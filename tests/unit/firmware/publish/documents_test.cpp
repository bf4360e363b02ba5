// What is committed is what the code says. To renew a document after a change of the table: run this test
// with ADIT_WRITE_DOCUMENTS=1 in the environment.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "firmware/publish/dbc.h"
#include "firmware/publish/wire_text.h"

#include <CppUTest/TestHarness.h>

namespace adit::publish {
namespace {

void CheckDocument(const std::string& path, const std::string& text) {
  if (std::getenv("ADIT_WRITE_DOCUMENTS") != nullptr) std::ofstream(path) << text;
  std::ifstream file(path);
  const std::string committed{std::istreambuf_iterator<char>(file), {}};
  STRCMP_EQUAL(committed.c_str(), text.c_str());
}

}  // namespace

TEST_GROUP(Documents){};

TEST(Documents, TheDbcIsTheTables) { CheckDocument("docs/adit-can.dbc", FormatDbc(0x20)); }
TEST(Documents, TheCanPageIsTheTables) { CheckDocument("docs/adit-can.md", FormatCanDocument()); }
TEST(Documents, TheModbusPageIsTheTables) { CheckDocument("docs/modbus-map.md", FormatModbusDocument()); }

TEST(Documents, TheDbcOfAHighNodeHasNoInfo) {
  CHECK(FormatDbc(0x5F).find("ADIT_INFO") != std::string::npos);
  CHECK(FormatDbc(0x60).find("ADIT_INFO") == std::string::npos);
  CHECK(FormatDbc(0x60).find("BO_ 1760 ") == std::string::npos);
}

}  // namespace adit::publish
