// A folder of its own for a test, gone when the test ends.
#pragma once

#include <string>

#include "common/util/file.h"

namespace isolux::testing {

class TempDir {
 public:
  TempDir();

  const std::string& path() const { return folder_.path(); }
  // Writes a file below the folder, making folders on the way, and returns its path.
  std::string Write(const std::string& name, const std::string& bytes) const;

 private:
  TemporaryDirectory folder_;
};

}  // namespace isolux::testing
