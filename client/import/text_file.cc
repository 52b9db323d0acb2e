#include "client/import/text_file.h"

#include <strings.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace isolux {
namespace {

namespace fs = std::filesystem;

bool IsBlank(char c) { return c == ' ' || c == '\t'; }

bool IsRegularFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

}  // namespace

Result<CleanText> CleanText::FromBytes(std::string bytes, std::string name) {
  CleanText result;
  result.text_ = std::move(bytes);
  result.name_ = std::move(name);
  std::string& text = result.text_;
  if (text.starts_with("\xef\xbb\xbf")) std::fill_n(text.begin(), 3, ' ');
  bool comment = false;
  for (size_t i = 0; i < text.size(); ++i) {
    char& c = text[i];
    if (c == '\0') {
      return Error(StatusCode::kInvalidArgument,
                   "{}:{}: not a text file; export the scene as plain Wavefront OBJ", result.name_,
                   1 + std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(i), '\n'));
    }
    if (c == '\r') c = i + 1 < text.size() && text[i + 1] == '\n' ? ' ' : '\n';
    if (c == '\n') {
      comment = false;
      continue;
    }
    if (c == '#' && (i == 0 || IsBlank(text[i - 1]) || text[i - 1] == '\n')) comment = true;
    if (comment) {
      c = ' ';
      continue;
    }
    if (c == '\\') {  // a backslash before the line end joins the next line
      size_t end = i + 1;
      while (end < text.size() && (text[end] == '\r' || text[end] == ' ')) ++end;
      if (end < text.size() && text[end] == '\n') {
        std::fill(text.begin() + static_cast<ptrdiff_t>(i),
                  text.begin() + static_cast<ptrdiff_t>(end) + 1, ' ');
        result.joined_.push_back(end);
        i = end;
      }
    }
  }
  return result;
}

uint32_t CleanText::LineBefore(size_t position) {
  position = std::min(position, text_.size());
  if (position > counted_) {
    lines_ +=
        static_cast<uint32_t>(std::count(text_.begin() + static_cast<ptrdiff_t>(counted_),
                                         text_.begin() + static_cast<ptrdiff_t>(position), '\n'));
    while (next_joined_ < joined_.size() && joined_[next_joined_] < position) {
      ++next_joined_;
      ++lines_;
    }
    counted_ = position;
  }
  const bool inside_line = position > 0 && text_[position - 1] != '\n';
  return lines_ + (inside_line ? 1 : 0);
}

std::string_view Trim(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  size_t i = 0;
  while (true) {
    while (i < line.size() && IsBlank(line[i])) ++i;
    if (i == line.size()) return words;
    const size_t start = i;
    while (i < line.size() && !IsBlank(line[i])) ++i;
    words.push_back(line.substr(start, i - start));
  }
}

std::optional<double> ParseNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  // Out of range is an overflow, or an underflow, which is as good as zero.
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(word).c_str(), nullptr);
  if (error == std::errc::invalid_argument || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string FolderOf(const std::string& path) { return fs::path(path).parent_path().string(); }

std::string FindFile(const std::string& folder, const std::string& name) {
  if (name.empty()) return {};
  std::string slashes = name;
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  for (const std::string& candidate : {name, slashes}) {
    const fs::path path = fs::path(folder) / candidate;
    if (IsRegularFile(path)) return path.string();
  }
  const fs::path wanted = fs::path(folder) / slashes;
  std::error_code error;
  fs::path parent = wanted.parent_path();
  if (parent.empty()) parent = ".";
  std::vector<std::string> found;  // sorted, so that the choice does not depend on the file system
  for (fs::directory_iterator it(parent, error), end; !error && it != end; it.increment(error)) {
    const std::string entry = it->path().filename().string();
    if (strcasecmp(entry.c_str(), wanted.filename().c_str()) == 0 && IsRegularFile(it->path())) {
      found.push_back(it->path().string());
    }
  }
  return found.empty() ? std::string() : *std::min_element(found.begin(), found.end());
}

}  // namespace isolux
