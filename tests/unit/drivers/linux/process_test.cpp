#include "drivers/linux/process.h"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "drivers/linux/signals.h"
#include "drivers/linux/system_clock.h"

#include <CppUTest/TestHarness.h>

using adit::base::kNsPerMs;
using adit::base::kNsPerS;
using adit::linux::MonotonicNs;
using adit::linux::Process;

namespace {

constexpr std::int64_t kLongNs = 20 * kNsPerS;  // far more than a loaded machine needs for a shell

Process Shell(const std::string& script) {
  auto process = Process::Spawn({"sh", "-c", script});
  CHECK(!!process);
  return std::move(*process);
}

}  // namespace

TEST_GROUP(Process){};

TEST(Process, ReadsLinesAndTheExitCode) {
  Process child = Shell("echo one; echo; printf last; exit 7");
  STRCMP_EQUAL("one", child.ReadLine(kLongNs).value_or("none").c_str());
  STRCMP_EQUAL("", child.ReadLine(kLongNs).value_or("none").c_str());
  STRCMP_EQUAL("last", child.ReadLine(kLongNs).value_or("none").c_str());
  CHECK_FALSE(child.ReadLine(kLongNs).has_value());
  CHECK_TRUE(child.OutputEnded());
  const auto end = child.WaitFor(kLongNs);
  CHECK_TRUE(end.has_value());
  LONGS_EQUAL(7, end->exit_code);
  LONGS_EQUAL(7, child.WaitFor(0)->exit_code);
}

TEST(Process, PassesArgumentsAsTheyAre) {
  auto child = Process::Spawn({"printf", "%s|", "a b", "", "$HOME", "'"});
  CHECK(!!child);
  STRCMP_EQUAL("a b||$HOME|'|", child->ReadLine(kLongNs).value_or("none").c_str());
}

TEST(Process, NamesAProgramThatDoesNotExist) {
  const auto child = Process::Spawn({"/no/such/program", "x"});
  CHECK_FALSE(child);
  STRCMP_EQUAL("/no/such/program: cannot be started: No such file or directory",
               child.error().Line().c_str());
}

TEST(Process, GivesUpALineAfterTheTimeout) {
  Process child = Shell("exec sleep 60");
  const std::int64_t start_ns = MonotonicNs();
  CHECK_FALSE(child.ReadLine(20 * kNsPerMs).has_value());
  CHECK_FALSE(child.OutputEnded());
  CHECK_FALSE(child.WaitFor(0).has_value());
  CHECK_TRUE(MonotonicNs() - start_ns < kLongNs);
}

TEST(Process, EndsAChildThatObeysBySigterm) {
  Process child = Shell("exec sleep 60");
  LONGS_EQUAL(128 + SIGTERM, child.Terminate(kLongNs).exit_code);
}

TEST(Process, KillsAChildThatIgnoresSigterm) {
  Process child = Shell("trap '' TERM; echo deaf; while :; do sleep 0.05; done");
  STRCMP_EQUAL("deaf", child.ReadLine(kLongNs).value_or("none").c_str());
  LONGS_EQUAL(128 + SIGKILL, child.Terminate(50 * kNsPerMs).exit_code);
}

TEST(Process, TerminatesWhatIsDestroyed) {
  pid_t id = 0;
  {
    Process child = Shell("exec sleep 60");
    id = child.Id();
    LONGS_EQUAL(0, kill(id, 0));
  }
  LONGS_EQUAL(-1, kill(id, 0));
}

TEST(Process, GivesTheChildAnEmptySignalMask) {
  adit::linux::StopSignals stop;  // blocks SIGTERM here
  Process child = Shell("exec sleep 60");
  LONGS_EQUAL(128 + SIGTERM, child.Terminate(kLongNs).exit_code);
}

TEST(Process, CountsTheCpuTimeOfTheChild) {
  Process child = Shell("i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done; echo done; read x < /dev/zero");
  STRCMP_EQUAL("done", child.ReadLine(kLongNs).value_or("none").c_str());
  CHECK_TRUE(child.CpuNs() > 5 * kNsPerMs);
  const auto end = child.Terminate(kLongNs);
  CHECK_TRUE(end.cpu_ns > 5 * kNsPerMs);
  LONGS_EQUAL(end.cpu_ns, child.CpuNs());
}

TEST(Process, WritesStandardErrorToAFile) {
  char name[] = "/tmp/adit-stderr-XXXXXX";
  close(mkstemp(name));
  auto child = Process::Spawn({"sh", "-c", "echo out; echo err >&2"}, {.stderr_path = name});
  CHECK(!!child);
  STRCMP_EQUAL("out", child->ReadLine(kLongNs).value_or("none").c_str());
  CHECK(child->WaitFor(kLongNs).has_value());
  std::string line;
  std::getline(std::ifstream(name), line);
  std::remove(name);
  STRCMP_EQUAL("err", line.c_str());
}
