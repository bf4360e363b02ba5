// adit: the workstation tools, one program with subcommands.
#include <CLI/CLI.hpp>

#include "host/calibrate.h"
#include "host/command_rules.h"
#include "host/config.h"
#include "host/demo.h"
#include "host/diff.h"
#include "host/evaluate.h"
#include "host/georef.h"
#include "host/inspect.h"
#include "host/intrinsics.h"
#include "host/latency.h"
#include "host/rig.h"
#include "host/serve.h"
#include "host/simulate.h"
#include "host/target.h"
#include "host/track.h"
#include "host/train.h"

int main(int argc, char** argv) {
  CLI::App app{"adit: optical machine guidance for tunnels and mines"};
  app.require_subcommand(1);
  app.fallthrough(false);
  int exit_code = 0;
  adit::host::AddSimulate(app, exit_code);
  adit::host::AddServe(app, exit_code);
  adit::host::AddTarget(app, exit_code);
  adit::host::AddTrain(app, exit_code);
  adit::host::AddIntrinsics(app, exit_code);
  adit::host::AddCalibrate(app, exit_code);
  adit::host::AddGeoref(app, exit_code);
  adit::host::AddTrack(app, exit_code);
  adit::host::AddEvaluate(app, exit_code);
  adit::host::AddDiff(app, exit_code);
  adit::host::AddInspect(app, exit_code);
  adit::host::AddRig(app, exit_code);
  adit::host::AddConfig(app, exit_code);
  adit::host::AddLatency(app, exit_code);
  adit::host::AddDemo(app, exit_code);
  adit::host::AddCommandRules(app);
  // CLI11 would only say that a command is missing.
  const auto is_named = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(is_named).empty()) {
    std::cerr << "adit: there is no command '" << argv[1] << "' (adit --help)\n";
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help
    std::cerr << "adit: " << e.what() << " (adit --help)\n";
    return 2;
  }
  return exit_code;
}
