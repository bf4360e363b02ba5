#include "firmware/track/body.h"

#include "tests/support/scratch_folder.h"
#include "tests/unit/firmware/track/simulated_body.h"

#include <CppUTest/TestHarness.h>

using adit::tests::kBars;
using adit::track::LoadBodies;
using adit::track::LoadBody;

namespace {

const std::string kBarA = "  - {name: bar_a, at_m: [-2, 1.6, 1.2], direction: [0, -2, 0]}\n";
const std::string kBarB = "  - {name: bar_b, at_m: [-2, -0.2, 1.5], direction: [0, -0.9, -0.4]}\n";

}  // namespace

TEST_GROUP(Body) {
  adit::tests::ScratchFolder folder;

  std::string Complaint(const std::string& text) {
    const auto body = LoadBody(folder.Write("body.yaml", text), kBars);
    return body ? "" : body.error().Line();
  }
  void CheckNames(const std::string& complaint, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) STRCMP_CONTAINS(part.c_str(), complaint.c_str());
    CHECK(complaint.find('\n') == std::string::npos);
  }
};

TEST(Body, IsReadWithItsBarsInTheirOrder) {
  const auto body = LoadBody(folder.Write("b.yaml", "name: loader\ntargets:\n" + kBarB + kBarA), kBars);
  CHECK(!!body);
  STRCMP_EQUAL("loader", body->name.c_str());
  DOUBLES_EQUAL(0.001, body->sigma_m, 0);
  LONGS_EQUAL(2, body->bars.size());
  LONGS_EQUAL(1, body->bars[0].target);
  LONGS_EQUAL(0, body->bars[1].target);
  CHECK(body->bars[1].direction_t.isApprox(Eigen::Vector3d(0, -1, 0)));
  CHECK(body->bars[1].CentreM().isApprox(Eigen::Vector3d(-2, 1.0, 1.2)));  // LEDs at 0, 0.25, 0.65, 1.5
  DOUBLES_EQUAL(1.5, body->bars[0].length_m, 0);
}

TEST(Body, NamesFileKeyValueAndWhatIsAllowed) {
  CheckNames(Complaint("targets:\n" + kBarA + kBarB), {"body.yaml", "name", "missing"});
  CheckNames(Complaint("name: a,b\ntargets:\n" + kBarA + kBarB), {"name", "commas"});
  CheckNames(Complaint("name: x\n"), {"targets", "has 0", "2 to 8"});
  CheckNames(Complaint("name: x\ntargets:\n" + kBarA), {"targets", "has 1", "2 to 8"});
  CheckNames(Complaint("name: x\ntargets:\n" + kBarA + kBarA), {"bar_a", "second time"});
  CheckNames(
      Complaint("name: x\ntargets:\n" + kBarA + "  - {name: bar_z, at_m: [0, 0, 0], direction: [1, 0, 0]}\n"),
      {"bar_z", "no model"});
  CheckNames(
      Complaint("name: x\ntargets:\n" + kBarA + "  - {name: bar_b, at_m: [0, 0], direction: [1, 0, 0]}\n"),
      {"at_m", "3"});
  CheckNames(
      Complaint("name: x\ntargets:\n" + kBarA + "  - {name: bar_b, at_m: [0, 0, 0], direction: [0, 0, 0]}\n"),
      {"direction", "no length"});
  CheckNames(Complaint("name: x\nsigma_m: 2\ntargets:\n" + kBarA + kBarB), {"sigma_m", "2", "0.1"});
  CheckNames(Complaint("name: x\nmass_kg: 2\ntargets:\n" + kBarA + kBarB), {"mass_kg", "not known"});
}

TEST(Body, RefusesBarsOnOneLineForTheyShowNoTurnAroundIt) {
  CheckNames(Complaint("name: x\ntargets:\n" + kBarA +
                       "  - {name: bar_b, at_m: [-2, -1, 1.23], direction: [0, 1, 0]}\n"),
             {"targets", "one line"});
}

TEST(Body, SeveralMustDifferInTheirNamesAndFitTheBox) {
  const std::string one = folder.Write("one.yaml", "name: loader\ntargets:\n" + kBarA + kBarB);
  const std::string named_as_a_bar = folder.Write("bar.yaml", "name: bar_c\ntargets:\n" + kBarA + kBarB);
  CHECK(!!LoadBodies({one}, kBars, 1));
  CheckNames(LoadBodies({one, one}, kBars, 9).error().Line(), {"one.yaml", "name", "loader", "differ"});
  CheckNames(LoadBodies({named_as_a_bar}, kBars, 9).error().Line(), {"bar.yaml", "bar_c", "differ"});
  CheckNames(LoadBodies({one}, kBars, 0).error().Line(), {"there are 1", "at most 0"});
  CheckNames(LoadBodies({"nowhere.yaml"}, kBars, 1).error().Line(), {"nowhere.yaml"});
}
