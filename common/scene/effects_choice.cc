#include "common/scene/effects_choice.h"

#include <algorithm>

namespace isolux {
namespace {

constexpr size_t kLongestText = 1024;

Status Switch(std::string_view word, EffectsChoice* choice) {
  const bool on = word.front() == '+';
  const std::string name(word.substr(1));
  if (std::ranges::find(kSwitchableEffects, name) == kSwitchableEffects.end()) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "effects: there is no effect '{}' that can be switched: choose among {}",
                      name, fmt::join(kSwitchableEffects, ", "));
  }
  (on ? choice->on : choice->off).insert(name);
  (on ? choice->off : choice->on).erase(name);  // the last word counts
  return {};
}

}  // namespace

Result<EffectsChoice> ParseEffectsChoice(std::string_view text) {
  if (text.size() > kLongestText) {
    return Error(StatusCode::kInvalidArgument, "effects: more than {} characters", kLongestText);
  }
  std::string kept;
  std::ranges::copy_if(text, std::back_inserter(kept), [](char c) { return c != ' '; });
  EffectsChoice choice;
  bool first = true;
  for (size_t begin = 0; begin < kept.size(); first = false) {
    const size_t end = std::min(kept.find(',', begin), kept.size());
    const std::string_view word = std::string_view(kept).substr(begin, end - begin);
    begin = end + 1;
    if (!word.empty() && (word.front() == '+' || word.front() == '-')) {
      RETURN_IF_ERROR(Switch(word, &choice));
    } else if (first && (word == "auto" || word == "all" || word == "none")) {
      choice.base = word == "auto"  ? EffectsChoice::Base::kAuto
                    : word == "all" ? EffectsChoice::Base::kAll
                                    : EffectsChoice::Base::kNone;
    } else {
      return Error(StatusCode::kInvalidArgument,
                   "effects: '{}' is none of auto, all, none (the first word), +NAME, -NAME", word);
    }
  }
  return choice;
}

}  // namespace isolux
