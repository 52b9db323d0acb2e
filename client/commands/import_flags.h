// The flags of every command that reads a scene file.
#pragma once

#include <string>

#include "client/import/import.h"

namespace CLI {
class App;
}

namespace isolux {

// Registers --emit, --reflect, --unit and --strict. `options` must outlive the parsing.
void AddImportFlags(CLI::App& command, ImportOptions* options);

// Registers --effects, of the commands that solve or say what a solve would do.
void AddEffectsFlag(CLI::App& command, std::string* effects);

// One line for each thing the importer mended; empty where there was nothing.
std::string DescribeRepairs(const RepairReport& repairs);

}  // namespace isolux
