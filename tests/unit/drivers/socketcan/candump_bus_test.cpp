#include "drivers/socketcan/candump_bus.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include <CppUTest/TestHarness.h>

namespace adit::socketcan {
namespace {

class SetClock final : public hal::Clock {
 public:
  base::TimeNs Now() const override { return now_ns_; }
  void Set(base::TimeNs now_ns) { now_ns_ = now_ns; }

 private:
  base::TimeNs now_ns_ = 1'700'000'000'000'345'999;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string TemporaryFolder() {
  std::string path = "/tmp/adit-candump-XXXXXX";
  return ::mkdtemp(path.data()) != nullptr ? path : "";
}

}  // namespace

TEST_GROUP(CandumpBus) {
  SetClock clock_;
  std::string folder_ = TemporaryFolder();
  std::string path_ = folder_ + "/bus.log";

  void teardown() override {
    (void)::unlink(path_.c_str());
    (void)::rmdir(folder_.c_str());
  }
};

TEST(CandumpBus, WritesTheLinesOfCandump) {
  auto bus = CandumpBus::Open(path_, "can0", clock_);
  const std::vector<base::CanFrame> epoch{
      {.id = 0x1A0, .data = {0x87, 0xC9, 0xEE, 0xF6, 0x4D, 0x17, 0x49, 0xFA}},
      {.id = 0x7F, .length = 1, .data = {5}},
      {.id = 0x18FF40C8, .extended = true, .length = 2, .data = {1, 2}},
      {.id = 0x80, .length = 0}};
  CHECK((*bus)->SendEpoch(epoch) == hal::SendOutcome::kSent);
  STRCMP_EQUAL(
      "(1700000000.000345) can0 1A0#87C9EEF64D1749FA\n"
      "(1700000000.000345) can0 07F#05\n"
      "(1700000000.000345) can0 18FF40C8#0102\n"
      "(1700000000.000345) can0 080#\n",
      ReadFile(path_).c_str());
  LONGS_EQUAL(4, (*bus)->Health().sent_frames);
  LONGS_EQUAL(1, (*bus)->Health().confirmed_epochs);
}

TEST(CandumpBus, AppendsToWhatIsThere) {
  std::ofstream(path_) << "before\n";
  auto bus = CandumpBus::Open(path_, "vcan7", clock_);
  const std::vector<base::CanFrame> epoch{{.id = 1, .length = 0}};
  (void)(*bus)->SendEpoch(epoch);
  clock_.Set(2'000'000);
  (void)(*bus)->SendEpoch(epoch);
  STRCMP_EQUAL("before\n(1700000000.000345) vcan7 001#\n(0000000000.002000) vcan7 001#\n",
               ReadFile(path_).c_str());
}

TEST(CandumpBus, AFullDiskDropsTheEpochAndCountsIt) {
  auto bus = CandumpBus::Open("/dev/full", "can0", clock_);
  const std::vector<base::CanFrame> epoch{{.id = 1}};
  CHECK((*bus)->SendEpoch(epoch) == hal::SendOutcome::kDropped);
  LONGS_EQUAL(1, (*bus)->Health().dropped_epochs);
  LONGS_EQUAL(1, (*bus)->Health().errors);
  LONGS_EQUAL(0, (*bus)->Health().sent_frames);
}

TEST(CandumpBus, TooManyFramesAreDroppedWhole) {
  auto bus = CandumpBus::Open(path_, "can0", clock_);
  const std::vector<base::CanFrame> epoch(CandumpBus::kMaxEpochFrames + 1);
  CHECK((*bus)->SendEpoch(epoch) == hal::SendOutcome::kDropped);
  STRCMP_EQUAL("", ReadFile(path_).c_str());
}

TEST(CandumpBus, TheLargestEpochFits) {
  auto bus = CandumpBus::Open(path_, "channel-of-15-c", clock_);
  const std::vector<base::CanFrame> epoch(CandumpBus::kMaxEpochFrames, {.id = 0x1FFFFFFF, .extended = true});
  CHECK((*bus)->SendEpoch(epoch) == hal::SendOutcome::kSent);
  LONGS_EQUAL(CandumpBus::kMaxEpochFrames *
                  std::string("(1700000000.000345) channel-of-15-c 1FFFFFFF#0000000000000000\n").size(),
              ReadFile(path_).size());
}

TEST(CandumpBus, DeclinesAFolderThatIsNotThere) {
  auto bus = CandumpBus::Open(folder_ + "/none/bus.log", "can0", clock_);
  CHECK_FALSE(static_cast<bool>(bus));
  STRCMP_CONTAINS("none/bus.log: cannot be opened for CAN frames: No such file", bus.error().Line().c_str());
}

TEST(CandumpBus, DeclinesAChannelThatIsNoInterfaceName) {
  CHECK_FALSE(static_cast<bool>(CandumpBus::Open(path_, "", clock_)));
  CHECK_FALSE(static_cast<bool>(CandumpBus::Open(path_, "sixteen-chars-xx", clock_)));
}

}  // namespace adit::socketcan
