// What the readers of OBJ and MTL files share: lines that are still known by number after cleaning,
// numbers parsed strictly, files found whatever the case of their name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/status.h"

namespace isolux {

// A file's text made uniform without moving a byte: line ends are '\n', comments (# at the start of
// a line or behind a blank) and the byte order mark are blanks, continued lines are joined.
class CleanText {
 public:
  // Fails where the bytes are not text.
  static Result<CleanText> FromBytes(std::string bytes, std::string name);

  const std::string& text() const { return text_; }
  std::string& text() { return text_; }
  const std::string& name() const { return name_; }  // as messages show it

  // Number, from 1, of the line that ends at or holds the byte before `position`. Positions must
  // not fall from call to call.
  uint32_t LineBefore(size_t position);

 private:
  std::string text_;
  std::string name_;
  std::vector<size_t> joined_;  // where line ends were blanked, ascending
  size_t counted_ = 0;          // bytes of text_ whose line ends are in lines_
  size_t next_joined_ = 0;
  uint32_t lines_ = 0;
};

// Splits at blanks.
std::vector<std::string_view> Words(std::string_view line);
std::string_view Trim(std::string_view text);

// The whole word as a finite number.
std::optional<double> ParseNumber(std::string_view word);

// `name` in `folder` as it is, else with '\' read as '/', else by its last part in any case; empty
// where no such regular file exists. An absolute name is taken as it is.
std::string FindFile(const std::string& folder, const std::string& name);
std::string FolderOf(const std::string& path);

}  // namespace isolux
