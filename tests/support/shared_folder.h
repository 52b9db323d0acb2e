// The folder of scenes and exact cases from elsewhere that some tests read where it is at hand.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace isolux::testing {

// ISOLUX_SHARED, or `shared` beside the source tree; empty where that is no folder.
inline std::string SharedFolder() {
  const char* given = std::getenv("ISOLUX_SHARED");
  const std::filesystem::path folder =
      given != nullptr ? std::filesystem::path(given)
                       : std::filesystem::path(ISOLUX_SOURCE_DIR).parent_path() / "shared";
  return std::filesystem::is_directory(folder) ? folder.string() : std::string();
}

}  // namespace isolux::testing
