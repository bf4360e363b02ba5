// main of every unit test program.
#include <CppUTest/CommandLineTestRunner.h>
#include <CppUTest/MemoryLeakWarningPlugin.h>

int main(int argc, char** argv) {
  // CppUTest's leak book does not see what shared libraries (yaml-cpp, OpenCV, Ceres) free and reports their
  // memory as leaked. The asan preset has LeakSanitizer look at the same tests.
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
