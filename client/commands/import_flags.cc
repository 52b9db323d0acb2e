#include "client/commands/import_flags.h"

#include <CLI/CLI.hpp>
#include <string>

namespace isolux {

void AddImportFlags(CLI::App& command, ImportOptions* options) {
  command
      .add_option_function<std::string>(
          "--emit", [options](const std::string& sides) { options->emit_both = sides == "both"; },
          "sides from which emitters radiate; front is the counter-clockwise one")
      ->check(CLI::IsMember({"front", "both"}))
      ->default_str("front");
  command
      .add_option_function<std::string>(
          "--reflect",
          [options](const std::string& sides) { options->reflect_front = sides == "front"; },
          "sides that reflect and receive")
      ->check(CLI::IsMember({"both", "front"}))
      ->default_str("both");
  command.add_option("--unit", options->unit, "unit of the file's coordinates")
      ->check(CLI::IsMember({"m", "cm", "mm", "in", "ft"}))
      ->capture_default_str();
  command.add_flag("--strict", options->strict, "refuse a scene that would have to be mended");
}

void AddEffectsFlag(CLI::App& command, std::string* effects) {
  command
      .add_option("--effects", *effects,
                  "what to simulate: auto|all|none, then +NAME and -NAME, separated by commas")
      ->capture_default_str();
}

std::string DescribeRepairs(const RepairReport& repairs) {
  std::string text;
  for (const RepairReport::Entry& entry : repairs.entries) {
    text += fmt::format("{:>9}  {}", entry.count, entry.kind);
    if (!entry.example.empty()) text += fmt::format(" ({})", entry.example);
    text += '\n';
  }
  return text;
}

}  // namespace isolux
