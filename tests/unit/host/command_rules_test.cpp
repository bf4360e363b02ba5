#include "host/command_rules.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace fs = std::filesystem;

// A command below a command, as `adit rig correct`, that must not run when a rule is broken.
TEST_GROUP(CommandRules) {
  fs::path folder;
  CLI::App* app = nullptr;
  double limit_mm = 3;
  std::vector<double> offset_m;
  std::string in, out;
  bool has_run = false;

  void setup() override {
    std::string name = (fs::temp_directory_path() / "adit-rules-XXXXXX").string();
    CHECK(mkdtemp(name.data()) != nullptr);
    folder = name;
    std::ofstream(folder / "points.csv") << "points";
    app = new CLI::App;
    CLI::App* command = app->add_subcommand("rig", "")->add_subcommand("correct", "");
    command->add_option("--limit-mm", limit_mm)->check(CLI::Range(0.01, 1e4));
    command->add_option("--offset-m", offset_m)->expected(3);
    command->add_option("--points", in);
    command->add_option("--out", out);
    command->callback([this] { has_run = true; });
    adit::host::AddCommandRules(*app);
  }
  void teardown() override {
    delete app;
    fs::remove_all(folder);
    folder.clear(), in.clear(), out.clear();
    offset_m = {};
  }

  /// What parsing says; empty if the command ran.
  std::string Says(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"correct", "rig"});  // CLI11 takes them from the back
    has_run = false;
    try {
      app->parse(arguments);
    } catch (const CLI::ParseError& error) {
      CHECK_FALSE(has_run);
      return error.what();
    }
    CHECK(has_run);
    return "";
  }
};

TEST(CommandRules, RefuseNumbersThatAreNone) {
  for (const char* text : {"nan", "NaN"}) {
    STRCMP_CONTAINS("--limit-mm", Says({text, "--limit-mm"}).c_str());
    STRCMP_CONTAINS("is no finite number", Says({"2", text, "1", "--offset-m"}).c_str());
  }
  STRCMP_CONTAINS("--offset-m", Says({"2", "inf", "1", "--offset-m"}).c_str());
  STRCMP_EQUAL("", Says({"2.5", "--limit-mm", "3", "-2", "1e3", "--offset-m"}).c_str());
  DOUBLES_EQUAL(2.5, limit_mm, 0);
}

TEST(CommandRules, RefuseAnOutputThatIsRead) {
  const std::string points = folder / "points.csv";
  fs::create_symlink("points.csv", folder / "link");
  for (const fs::path& same : {folder / "points.csv", folder / "." / "points.csv", folder / "link"}) {
    const std::string said = Says({same.string(), "--out", points, "--points"});
    STRCMP_CONTAINS("--out", said.c_str());
    STRCMP_CONTAINS("is what --points reads", said.c_str());
  }
  STRCMP_EQUAL("", Says({(folder / "new.csv").string(), "--out", points, "--points"}).c_str());
  std::ofstream(folder / "old.csv") << "old";
  STRCMP_EQUAL("", Says({(folder / "old.csv").string(), "--out", points, "--points"}).c_str());
}
