#include "client/import/ies_file.h"

#include <cmath>
#include <string_view>

#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr uint64_t kMostIesBytes = 64 << 20;

// The numbers of a file behind its TILT line, wherever its lines end.
class Numbers {
 public:
  Numbers(std::string_view text, size_t line, const std::string& name)
      : rest_(text), line_(line), name_(name) {}

  template <typename... Args>
  internal::Failure Error(fmt::format_string<Args...> format, Args&&... args) const {
    return {MakeStatus(StatusCode::kInvalidArgument, "{}:{}: {}", name_, line_,
                       fmt::format(format, std::forward<Args>(args)...))};
  }

  Result<double> Next(const char* what) {
    size_t begin = 0;
    while (begin < rest_.size() && IsBlank(rest_[begin])) {
      if (rest_[begin++] == '\n') ++line_;
    }
    size_t end = begin;
    while (end < rest_.size() && !IsBlank(rest_[end])) ++end;
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    if (word.empty()) return Error("the file ends before {}; is it whole?", what);
    if (const auto number = ParseNumber(word)) return *number;
    return Error("'{}' is no number, where {} should stand", word.substr(0, 40), what);
  }

  Result<uint32_t> Count(const char* what, uint32_t least, uint32_t most) {
    ASSIGN_OR_RETURN(const double number, Next(what));
    if (number >= least && number <= most && number == std::floor(number)) {
      return static_cast<uint32_t>(number);
    }
    return Error("{}, {}: it must be a whole number from {} to {}", what, number, least, most);
  }

  Status Skip(uint32_t count, const char* what) {
    for (uint32_t i = 0; i < count; ++i) {
      ASSIGN_OR_RETURN([[maybe_unused]] const double unused, Next(what));
    }
    return {};
  }

  Status Fill(size_t count, double factor, const char* what, std::vector<float>* numbers) {
    for (size_t i = 0; i < count; ++i) {
      ASSIGN_OR_RETURN(const double number, Next(what));
      numbers->push_back(static_cast<float>(factor * number));
    }
    return {};
  }

 private:
  static bool IsBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',';
  }

  std::string_view rest_;
  size_t line_;
  const std::string& name_;
};

}  // namespace

Result<Photometry> ParseIes(const std::string& bytes, const std::string& name) {
  std::string_view text = bytes, tilt;
  size_t line = 0;
  while (!text.empty() && tilt.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view head = text.substr(0, end);
    while (head.ends_with('\r') || head.ends_with(' ')) head.remove_suffix(1);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line;
    if (head.starts_with("TILT=")) tilt = head;
  }
  Numbers numbers(text, line + 1, name);
  if (tilt.empty()) {
    return numbers.Error("no line 'TILT=…': not a photometric file after IES LM-63");
  }
  if (tilt == "TILT=INCLUDE") {  // how lamps fare at other angles than the luminaire's
    ASSIGN_OR_RETURN([[maybe_unused]] const double geometry, numbers.Next("the lamp's geometry"));
    ASSIGN_OR_RETURN(const uint32_t pairs, numbers.Count("number of tilt angles", 0, 1000));
    RETURN_IF_ERROR(numbers.Skip(2 * pairs, "a tilt angle or factor"));
  } else if (tilt != "TILT=NONE") {
    return numbers.Error("'{}': a file of its own is not read; write TILT=NONE",
                         tilt.substr(0, 60));
  }
  RETURN_IF_ERROR(numbers.Skip(2, "number and lumens of lamps"));
  ASSIGN_OR_RETURN(const double multiplier, numbers.Next("multiplier"));
  constexpr uint32_t kMost = Photometry::kMostAngles;
  ASSIGN_OR_RETURN(const uint32_t columns, numbers.Count("number of vertical angles", 2, kMost));
  ASSIGN_OR_RETURN(const uint32_t rows, numbers.Count("number of horizontal angles", 1, kMost));
  ASSIGN_OR_RETURN(const uint32_t type, numbers.Count("photometric type", 1, 3));
  if (type != 1) {
    return numbers.Error("photometry of type {}; only type C (1) is read: convert it",
                         type == 2 ? "B (2)" : "A (3)");
  }
  RETURN_IF_ERROR(numbers.Skip(4, "unit and size of the luminaire"));
  ASSIGN_OR_RETURN(const double ballast, numbers.Next("ballast factor"));
  ASSIGN_OR_RETURN(const double lamp, numbers.Next("ballast-lamp factor"));
  RETURN_IF_ERROR(numbers.Skip(1, "input watts"));
  Photometry photometry;
  photometry.name = name;
  RETURN_IF_ERROR(numbers.Fill(columns, 1, "a vertical angle", &photometry.from_axis));
  RETURN_IF_ERROR(numbers.Fill(rows, 1, "a horizontal angle", &photometry.around));
  // The second factor was free before 1995; a 0 says nothing.
  const double factor = multiplier * ballast * (lamp > 0 ? lamp : 1.0);
  RETURN_IF_ERROR(numbers.Fill(static_cast<size_t>(columns) * rows, factor, "an intensity",
                               &photometry.intensity));
  if (const Status status = CheckPhotometry(photometry); !status.ok()) {
    return numbers.Error("{}", status.message());
  }
  return photometry;
}

Result<Photometry> ReadIes(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMostIesBytes));
  return ParseIes(bytes, path);
}

}  // namespace isolux
