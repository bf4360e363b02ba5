#include "host/command_rules.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace adit::host {
namespace {

constexpr std::array kOutputs{"--out", "--report", "--json", "--coverage"};

bool IsOutput(const CLI::Option& option) {
  return std::any_of(kOutputs.begin(), kOutputs.end(),
                     [&option](const char* name) { return option.check_name(name); });
}

/// Empty if the text is a finite number, or none at all, which CLI11 says itself.
std::string NotFinite(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool is_number = end != text.c_str() && *end == '\0';
  return is_number && !std::isfinite(value) ? "'" + text + "' is no finite number" : "";
}

void CheckOutputs(const CLI::App& command) {
  for (const CLI::Option* output : command.get_options()) {
    if (!IsOutput(*output)) continue;
    for (const CLI::Option* input : command.get_options()) {
      if (IsOutput(*input)) continue;
      for (const std::string& written : output->results()) {
        const auto is_read = [&written](const std::string& read) {
          std::error_code absent;
          return std::filesystem::equivalent(written, read, absent);
        };
        const auto& read = input->results();
        if (std::any_of(read.begin(), read.end(), is_read))
          throw CLI::ValidationError(output->get_name(), "'" + written + "' is what " + input->get_name() +
                                                             " reads; give another file");
      }
    }
  }
}

}  // namespace

void AddCommandRules(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    for (CLI::Option* option : command->get_options()) {
      if (option->get_type_name().starts_with("FLOAT")) option->check(NotFinite, "");
    }
    command->parse_complete_callback([command] { CheckOutputs(*command); });
    AddCommandRules(*command);
  }
}

}  // namespace adit::host
