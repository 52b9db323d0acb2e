#include "client/report/comments.h"

#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <vector>

namespace isolux {
namespace {

using nlohmann::json;

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(separator, begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// null where it is none.
json Number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? json(value) : json();
}

// Several numbers; null where a part is none.
json Numbers(std::string_view text, char separator) {
  json list = json::array();
  for (const std::string_view part : Split(text, separator)) {
    list.push_back(Number(part));
    if (list.back().is_null()) return {};
  }
  return list.empty() ? json() : list;
}

json Value(std::string_view text, char separator) {
  if (json number = Number(text); !number.is_null()) return number;
  if (json list = Numbers(text, separator); !list.is_null()) return list;
  return std::string(text);
}

// "2 epsilon 0.5 cpu_s 1,2" with `leading` {"round"}: the first words are values of those keys, the
// rest are keys and values in turn. A key without a value is left out.
json Row(std::string_view line, const std::vector<const char*>& leading) {
  const std::vector<std::string_view> words = Split(line, ' ');
  json row = json::object();
  size_t at = 0;
  for (; at < leading.size() && at < words.size(); ++at) row[leading[at]] = Value(words[at], ',');
  for (; at + 1 < words.size(); at += 2) row[std::string(words[at])] = Value(words[at + 1], ',');
  return row;
}

// "mirror not-simulated present yes bound 0.03 evidence WORDS": what an effect is called, what is
// done about it, and why.
json Effect(std::string_view line) {
  constexpr std::string_view kEvidence = " evidence ";
  const size_t at = std::min(line.find(kEvidence), line.size());
  json effect = Row(line.substr(0, at), {"name", "decision"});
  effect["present"] = effect.value("present", json()) == "yes";
  for (const char* key : {"bound", "measured"}) {
    if (effect.contains(key) && !effect[key].is_number()) effect[key] = nullptr;
  }
  effect["evidence"] = std::string(line.substr(std::min(at + kEvidence.size(), line.size())));
  return effect;
}

json Repair(std::string_view line) {
  const size_t blank = std::min(line.find(' '), line.size());
  return {{"count", Number(line.substr(0, blank))},
          {"what", std::string(line.substr(std::min(blank + 1, line.size())))}};
}

}  // namespace

json ReadComments(const PatchFile& file) {
  // Names that may read as numbers.
  static const std::set<std::string> texts{"version", "scene", "unit", "scene_hash"};
  json data = {{"summary", json::object()}, {"rounds", json::array()},
               {"traffic", json::array()},  {"worker_traffic", json::array()},
               {"effects", json::array()},  {"repairs", json::array()},
               {"doubts", json::array()}};
  for (const auto& [key, value] : file.comments) {
    if (key == "round") {
      data["rounds"].push_back(Row(value, {"round"}));
    } else if (key == "traffic") {
      data["traffic"].push_back(Row(value, {"phase"}));
    } else if (key == "worker_traffic") {
      data["worker_traffic"].push_back(Row(value, {"worker", "phase"}));
    } else if (key == "effect") {
      data["effects"].push_back(Effect(value));
    } else if (key == "doubt") {
      data["doubts"].push_back(value);
    } else if (key == "forecast") {
      continue;  // follows from the rounds
    } else if (key == "repair") {
      data["repairs"].push_back(Repair(value));
    } else {
      data["summary"][key] = texts.contains(key) ? json(value) : Value(value, ' ');
    }
  }
  return data;
}

}  // namespace isolux
