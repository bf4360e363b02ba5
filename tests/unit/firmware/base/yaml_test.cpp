#include "firmware/base/yaml.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>

#include <CppUTest/TestHarness.h>

using adit::base::ErrorCode;
using adit::base::YamlReader;

namespace {

/// The line that comes of asking `text` for `questions`; "" if all is well.
std::string Complaint(const std::string& text, const std::function<void(YamlReader&)>& questions) {
  auto in = YamlReader::OpenText(text, "f.yaml");
  if (!in) return in.error().Line();
  questions(*in);
  const auto done = in->Finish();
  return done ? "" : done.error().Line();
}

std::string Refused(const std::string& text) {
  return Complaint(text, [](YamlReader&) {});
}

void Number(YamlReader& in) { in.Number("a", {0, 10}); }

#define COMPLAINS(expected, ...) STRCMP_EQUAL(expected, Complaint(__VA_ARGS__).c_str())

}  // namespace

TEST_GROUP(Yaml){};

TEST(Yaml, ReadsEveryKind) {
  auto in = YamlReader::OpenText(
      "n: 2.5\ni: -3\nb: yes\nt: text\nc: red\nl: [1, 2e-3]\nm: [[1, 2], [3, 4]]\ntexts: [x, y]\n"
      "child: {n: 7}\nitems: [{n: 1}, {n: 2}]\n",
      "f");
  CHECK(!!in);
  DOUBLES_EQUAL(2.5, in->Number("n"), 0);
  LONGS_EQUAL(-3, in->Integer("i"));
  CHECK_TRUE(in->BoolOr("b", false));
  STRCMP_EQUAL("text", in->Text("t").c_str());
  STRCMP_EQUAL("red", in->Choice("c", {"blue", "red"}).c_str());
  CHECK((in->Numbers("l", 2) == std::vector<double>{1, 0.002}));
  CHECK((in->Matrix("m", 2, 2) == std::vector<double>{1, 2, 3, 4}));
  CHECK((in->TextsOr("texts", {}) == std::vector<std::string>{"x", "y"}));
  DOUBLES_EQUAL(7, in->Child("child").Number("n"), 0);
  auto items = in->Items("items");
  LONGS_EQUAL(2, items.size());
  DOUBLES_EQUAL(2, items[1].Number("n"), 0);
  DOUBLES_EQUAL(1, items[0].Number("n"), 0);
  CHECK(!!in->Finish());
}

TEST(Yaml, FallsBackWhereAKeyIsAbsent) {
  auto in = YamlReader::OpenText("x: 1\n", "f");
  CHECK(!!in);
  in->Ignore("x");
  DOUBLES_EQUAL(4, in->NumberOr("n", 4), 0);
  LONGS_EQUAL(5, in->IntegerOr("i", 5));
  CHECK_TRUE(in->BoolOr("b", true));
  STRCMP_EQUAL("t", in->TextOr("t", "t").c_str());
  STRCMP_EQUAL("c", in->ChoiceOr("c", "c", {"c"}).c_str());
  LONGS_EQUAL(1, in->TextsOr("l", {"one"}).size());
  LONGS_EQUAL(0, in->Items("items").size());
  CHECK(!!in->Finish());
}

TEST(Yaml, ChecksGivenValuesOfOptionalKeys) {
  COMPLAINS("f.yaml: a: is '11'; it must be a number from 0 to 10", "a: 11", [](YamlReader& in) {
    in.NumberOr("a", 1, {0, 10});
  });
  COMPLAINS("f.yaml: a: is 'green'; it must be one of: blue, red", "a: green", [](YamlReader& in) {
    in.ChoiceOr("a", "red", {"blue", "red"});
  });
  COMPLAINS("f.yaml: a: is 'maybe'; it must be true or false", "a: maybe",
            [](YamlReader& in) { in.BoolOr("a", true); });
}

TEST(Yaml, NamesAMissingKeyAndWhatItMustBe) {
  COMPLAINS("f.yaml: a: is missing; it must be a number from 0 to 10", "b: 1", Number);
  COMPLAINS("f.yaml: a: is missing; it must be a text", "b: 1", [](YamlReader& in) { in.Text("a"); });
  COMPLAINS("f.yaml: a: is missing; it must be one of: x, y", "b: 1", [](YamlReader& in) {
    in.Choice("a", {"x", "y"});
  });
  COMPLAINS("f.yaml: a: is missing; it must be a list of 3, each a number", "b: 1",
            [](YamlReader& in) { in.Numbers("a", 3); });
  COMPLAINS("f.yaml: a: is missing; it must be 2 rows of 3 numbers", "b: 1",
            [](YamlReader& in) { in.Matrix("a", 2, 3); });
  COMPLAINS("f.yaml: a: is missing; it must be a map", "b: 1", [](YamlReader& in) { in.Child("a"); });
}

TEST(Yaml, RefusesWhatIsNoNumber) {
  for (const char* value :
       {"x", "1x", "0x10", "1 2", "'1,5'", "+", "1e999", ".nan", "nan", ".inf", "-.inf", "true", "''"}) {
    const std::string line = Complaint("a: " + std::string(value), Number);
    STRCMP_CONTAINS("f.yaml: a: is '", line.c_str());
    STRCMP_CONTAINS("'; it must be a number from 0 to 10", line.c_str());
  }
  COMPLAINS("f.yaml: a: is nothing; it must be a number from 0 to 10", "a:", Number);
  COMPLAINS("f.yaml: a: is a list of 1; it must be a number from 0 to 10", "a: [1]", Number);
  COMPLAINS("f.yaml: a: is a map; it must be a number from 0 to 10", "a: {b: 1}", Number);
}

TEST(Yaml, TakesTheEndsOfARangeAndNothingBeyond) {
  for (const char* value : {"0", "10", "-0.0", "1e1", "+5"})
    STRCMP_EQUAL("", Complaint("a: " + std::string(value), Number).c_str());
  COMPLAINS("f.yaml: a: is '-1e-9'; it must be a number from 0 to 10", "a: -1e-9", Number);
  COMPLAINS("f.yaml: a: is '10.001'; it must be a number from 0 to 10", "a: 10.001", Number);
  COMPLAINS("f.yaml: a: is '1'; it must be a number of at least 2", "a: 1",
            [](YamlReader& in) { in.Number("a", {.min = 2}); });
  COMPLAINS("f.yaml: a: is '1'; it must be a number of at most 0", "a: 1",
            [](YamlReader& in) { in.Number("a", {.max = 0}); });
}

TEST(Yaml, RefusesAFractionOrAHugeNumberAsAnInteger) {
  const auto integer = [](YamlReader& in) { in.Integer("a"); };
  COMPLAINS("f.yaml: a: is '1.5'; it must be a whole number", "a: 1.5", integer);
  COMPLAINS("f.yaml: a: is '1e300'; it must be a whole number", "a: 1e300", integer);
  COMPLAINS("", "a: 9007199254740992", integer);
}

TEST(Yaml, NamesTheElementOfAListThatIsWrong) {
  const auto numbers = [](YamlReader& in) { in.Numbers("a", 3, {0, 10}); };
  COMPLAINS("f.yaml: a[1]: is 'x'; it must be a number from 0 to 10", "a: [1, x, y]", numbers);
  COMPLAINS("f.yaml: a[2]: is a list of 1; it must be a number from 0 to 10", "a: [1, 2, [3]]", numbers);
  COMPLAINS("f.yaml: a[0]: is '.nan'; it must be a number from 0 to 10", "a: [.nan, 2, 3]", numbers);
  COMPLAINS("f.yaml: a: is a list of 2; it must be a list of 3, each a number from 0 to 10", "a: [1, 2]",
            numbers);
  COMPLAINS("f.yaml: a: is '1'; it must be a list of 3, each a number from 0 to 10", "a: 1", numbers);
  COMPLAINS("f.yaml: a[1]: is a map; it must be a text", "a: [x, {y: 1}]",
            [](YamlReader& in) { in.TextsOr("a", {}); });
  COMPLAINS("f.yaml: a: is 'x'; it must be a list of texts", "a: x",
            [](YamlReader& in) { in.TextsOr("a", {}); });
}

TEST(Yaml, NamesTheRowAndPlaceOfAMatrixThatIsWrong) {
  const auto matrix = [](YamlReader& in) { in.Matrix("a", 2, 2); };
  COMPLAINS("f.yaml: a: is a list of 3; it must be 2 rows of 2 numbers", "a: [[1, 2], [3, 4], [5, 6]]",
            matrix);
  COMPLAINS("f.yaml: a[1]: is a list of 1; it must be one of 2 rows of 2 numbers", "a: [[1, 2], [3]]",
            matrix);
  COMPLAINS("f.yaml: a[0]: is '1'; it must be one of 2 rows of 2 numbers", "a: [1, 2]", matrix);
  COMPLAINS("f.yaml: a[1][0]: is '.inf'; it must be a number", "a: [[1, 2], [.inf, 4]]", matrix);
}

TEST(Yaml, NamesThePathOfAKeyBelowOthers) {
  COMPLAINS("f.yaml: a.b.c: is missing; it must be a number", "a: {b: {}}",
            [](YamlReader& in) { in.Child("a").Child("b").Number("c"); });
  COMPLAINS("f.yaml: a[1].c: is 'x'; it must be a number", "a: [{c: 1}, {c: x}]", [](YamlReader& in) {
    for (YamlReader& item : in.Items("a")) item.Number("c");
  });
}

TEST(Yaml, SurvivesEveryQuestionToAListElementThatIsNoMap) {
  for (const char* element : {"5", "[1]", "~"}) {
    const std::string line = Complaint("a: [" + std::string(element) + "]", [](YamlReader& in) {
      for (YamlReader& item : in.Items("a")) {
        item.Number("x");
        item.Integer("x");
        item.BoolOr("x", true);
        item.Text("x");
        item.Choice("x", {"y"});
        item.Numbers("x", 2);
        item.Matrix("x", 2, 2);
        item.TextsOr("x", {});
        item.Child("x");
        item.Items("x");
        item.Keys();
      }
    });
    STRCMP_CONTAINS("f.yaml: a[0]: is ", line.c_str());
    STRCMP_CONTAINS("; it must be a map", line.c_str());
  }
}

TEST(Yaml, GivesTheSizeAskedForEvenWhenItRefuses) {
  auto in = YamlReader::OpenText("a: 1", "f");
  CHECK(!!in);
  LONGS_EQUAL(4, in->Numbers("a", 4).size());
  LONGS_EQUAL(6, in->Matrix("a", 2, 3).size());
  LONGS_EQUAL(4, in->Numbers("missing", 4).size());
}

TEST(Yaml, RefusesUnknownKeysAndListsTheKnownOnes) {
  COMPLAINS("f.yaml: exposre_us: is not known here; known: exposure_us, gain_db",
            "{gain_db: 1, exposre_us: 5}", [](YamlReader& in) {
              in.NumberOr("exposure_us", 0);
              in.NumberOr("gain_db", 0);
            });
  COMPLAINS("f.yaml: a.y: is not known here; known: x", "a: {x: 1, y: 2}",
            [](YamlReader& in) { in.Child("a").Number("x"); });
  COMPLAINS("f.yaml: a list of 1: is not known here; known: a", "{a: 1, [b]: 2}", Number);
}

TEST(Yaml, KeepsTheFirstOfSeveralMistakes) {
  COMPLAINS("f.yaml: b: is 'x'; it must be a number", "{a: y, b: x, c: 1}", [](YamlReader& in) {
    in.Number("b");
    in.Number("a");
    in.Refuse("c", "own finding");
  });
}

TEST(Yaml, TellsTheCallersOwnFindingWithItsPlace) {
  COMPLAINS("f.yaml: a.b: must differ from c", "a: {b: 1}", [](YamlReader& in) {
    YamlReader child = in.Child("a");
    child.Number("b");
    child.Refuse("b", "must differ from c");
  });
}

TEST(Yaml, RefusesAKeyThatStandsTwice) {
  COMPLAINS("f.yaml: a: stands there twice; give it once", "a: 1\nb: 2\na: 3\n", Number);
  COMPLAINS("f.yaml: c.a: stands there twice; give it once", "c: {a: 1, a: 1}",
            [](YamlReader& in) { in.Child("c").Number("a"); });
}

TEST(Yaml, RefusesWhatIsNoMap) {
  STRCMP_EQUAL("f.yaml: must be a map of keys, is nothing", Refused("").c_str());
  STRCMP_EQUAL("f.yaml: must be a map of keys, is nothing", Refused("# only a comment\n").c_str());
  STRCMP_EQUAL("f.yaml: must be a map of keys, is 'word'", Refused("word").c_str());
  STRCMP_EQUAL("f.yaml: must be a map of keys, is a list of 2", Refused("[1, 2]").c_str());
}

TEST(Yaml, RefusesASecondDocumentAndStrayEnds) {
  for (const char* text :
       {"a: 1\n---\na: 2\n", "---\na: 1\n---\n", "a: 1\n]", "a: 1\n}\n", "{a: 1}, b", "{a: 1},"}) {
    const std::string line = Refused(text);
    STRCMP_CONTAINS("f.yaml", line.c_str());
    CHECK_TRUE_TEXT(line.find("is not YAML: ") != std::string::npos ||
                        line.find("goes on after its first YAML document") != std::string::npos,
                    (text + (" gave " + line)).c_str());
  }
  STRCMP_CONTAINS("f.yaml", Refused(", x").c_str());
  COMPLAINS("", "# head\n---\na: 3\n...\n", Number);
}

TEST(Yaml, NamesTheLineThatIsNotYaml) {
  STRCMP_CONTAINS("f.yaml:3: is not YAML: ", Refused("a: 1\nb: [1, 2]\nc: d: e\n").c_str());
  for (const char* text : {"a: [1, 2", "a: {b: 1", "a: \"open", "\t- a", "*unknown", "a: &x *x", "@", "%"}) {
    const std::string line = Refused(text);
    CHECK_TRUE(line.rfind("f.yaml", 0) == 0);
    CHECK_TRUE(line.find('\n') == std::string::npos);
  }
}

TEST(Yaml, RefusesNestingWithoutEndInsteadOfOverflowingTheStack) {
  STRCMP_CONTAINS("f.yaml:1: is not YAML: ", Refused("a: " + std::string(100000, '[')).c_str());
}

TEST(Yaml, RefusesBinaryAndHugeContent) {
  STRCMP_EQUAL("f.yaml: is not YAML: it holds zero bytes, as binary files do",
               Refused(std::string("\x89PNG\0\0a: 1", 11)).c_str());
  STRCMP_EQUAL("f.yaml: is larger than 1 MiB; a settings file has some KB",
               Refused("a: 1\n" + std::string(10'000'000, '#')).c_str());
}

TEST(Yaml, StaysOneShortLineWhateverTheFileSays) {
  const std::string line = Complaint("a: \"x\\n\\e[31m" + std::string(5000, 'y') + "\"", Number);
  CHECK_TRUE(line.size() < 200);
  for (const char c : line) CHECK_TRUE(static_cast<unsigned char>(c) >= 0x20);
  // Cut between characters, not inside one.
  STRCMP_CONTAINS("\xC3\xA4...'", Complaint(
                                      "a: " +
                                          []() {
                                            std::string umlauts;
                                            for (int i = 0; i < 50; ++i) umlauts += "\xC3\xA4";
                                            return umlauts;
                                          }(),
                                      Number)
                                      .c_str());
}

TEST(Yaml, ReadsAnOpenCvHeader) { COMPLAINS("", "%YAML:1.0\n---\na: 3\n", Number); }

TEST(Yaml, QuotesTextSoThatItReadsBack) {
  STRCMP_EQUAL("\"a b\"", adit::base::Quoted("a b").c_str());
  for (const std::string text :
       {"\"", "\\", "a\nb\tc\r\x7f\x01", "null", "- x: y # z", "'", "\xC3\xA4", "\\x41", "%", "1e5"}) {
    auto in = YamlReader::OpenText(
        "a: " + adit::base::Quoted(text) + "\nb: [" + adit::base::Quoted(text) + "]\n", "f");
    CHECK(!!in);
    STRCMP_EQUAL(text.c_str(), in->Text("a").c_str());
    STRCMP_EQUAL(text.c_str(), in->TextsOr("b", {}).at(0).c_str());
  }
}

TEST(Yaml, NamesAFileThatCannotBeRead) {
  const auto missing = YamlReader::OpenFile("/no/such/file.yaml");
  CHECK_FALSE(missing);
  STRCMP_EQUAL("/no/such/file.yaml: cannot be read: No such file or directory",
               missing.error().Line().c_str());
  CHECK(missing.error().code == ErrorCode::kNotFound);
  const auto folder = YamlReader::OpenFile("/tmp");
  CHECK_FALSE(folder);
  STRCMP_EQUAL("/tmp: is a folder; give the path of a YAML file", folder.error().Line().c_str());
}

TEST(Yaml, IsNotHeldUpByADeviceWithoutEnd) {
  const auto endless = YamlReader::OpenFile("/dev/zero");
  CHECK_FALSE(endless);
  STRCMP_EQUAL("/dev/zero: is larger than 1 MiB; a settings file has some KB",
               endless.error().Line().c_str());
}

TEST(Yaml, ReadsAFileAndCallsAnEmptyOneMalformed) {
  char name[] = "/tmp/adit-yaml-XXXXXX";
  close(mkstemp(name));
  const auto empty = YamlReader::OpenFile(name);
  std::ofstream(name) << "a: 5\n";
  auto filled = YamlReader::OpenFile(name);
  std::remove(name);
  CHECK_FALSE(empty);
  CHECK(empty.error().code == ErrorCode::kMalformed);
  CHECK(!!filled);
  DOUBLES_EQUAL(5, filled->Number("a"), 0);
}
