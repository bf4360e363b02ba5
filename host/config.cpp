#include "host/config.h"

#include <iostream>
#include <memory>
#include <string>

#include "firmware/config/box_config.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace adit::host {
namespace {

int FailConfig(const base::Error& error) {
  std::cerr << "adit config: " << error.Line() << "\n";
  return error.ExitCode();
}

/// The box file and everything it names.
int CheckConfig(const std::string& path) {
  const auto config = config::LoadBoxConfig(path);
  if (!config) return FailConfig(config.error());
  const auto rig = optics::LoadRig(config->Resolve(config->rig));
  if (!rig) return FailConfig(rig.error());
  for (const std::string& file : config->models) {
    const auto model = identify::LoadModel(config->Resolve(file));
    if (!model) return FailConfig(model.error());
  }
  std::cout << path << ": good (rig " << rig->calibration_id << ", baseline " << rig->BaselineM() << " m, "
            << config->models.size() << " models)\n";
  return 0;
}

int ShowConfig(const std::string& path) {
  const auto config = config::LoadBoxConfig(path);
  if (!config) return FailConfig(config.error());
  std::cout << config::FormatBoxConfig(*config);
  return 0;
}

}  // namespace

void AddConfig(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("config", "check, explain or show a box's configuration");
  command->require_subcommand(1);
  auto file = std::make_shared<std::string>();
  CLI::App* check = command->add_subcommand("check", "read the file and all it names");
  check->add_option("FILE", *file)->required();
  check->callback([file, &exit_code] { exit_code = CheckConfig(*file); });
  CLI::App* show = command->add_subcommand("show", "the configuration in effect, defaults included");
  show->add_option("FILE", *file)->required();
  show->callback([file, &exit_code] { exit_code = ShowConfig(*file); });
  CLI::App* schema = command->add_subcommand("schema", "every key with unit, default and range");
  schema->callback([] { std::cout << config::FormatBoxSchema(); });
}

}  // namespace adit::host
