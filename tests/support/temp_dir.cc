#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include "common/util/check.h"

namespace isolux::testing {
namespace {

TemporaryDirectory MakeOrStop() {
  Result<TemporaryDirectory> folder = TemporaryDirectory::Make("isolux-test");
  CHECK(folder.has_value());
  return *std::move(folder);
}

}  // namespace

TempDir::TempDir() : folder_(MakeOrStop()) {}

std::string TempDir::Write(const std::string& name, const std::string& bytes) const {
  const std::filesystem::path path = std::filesystem::path(folder_.path()) / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

}  // namespace isolux::testing
