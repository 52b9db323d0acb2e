// An object of a JSON file by its place in it, for readers that name what is wrong with it.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct JsonElement {
  const nlohmann::json& json;
  std::string where;  // "isolux.json: lights[2]"

  template <typename... Args>
  internal::Failure Error(fmt::format_string<Args...> format, Args&&... args) const {
    return {MakeStatus(StatusCode::kInvalidArgument, "{}: {}", where,
                       fmt::format(format, std::forward<Args>(args)...))};
  }

  Status CheckKeys(std::initializer_list<std::string_view> known) const {
    if (!json.is_object()) return Error("not an object; write {{…}}");
    for (const auto& item : json.items()) {
      if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
        return Error("there is no key '{}' here: choose among {}", item.key(),
                     fmt::join(known, ", "));
      }
    }
    return {};
  }

  Result<double> Number(const char* key, std::optional<double> missing, double least,
                        double most) const {
    const auto found = json.find(key);
    if (found == json.end() && missing) return *missing;
    if (found != json.end() && found->is_number()) {
      const double value = found->get<double>();
      if (value >= least && value <= most) return value;
    }
    return Error("\"{}\" must be a number from {} to {}", key, least, most);
  }

  Result<Vec3> Vector(const char* key) const {
    const auto found = json.find(key);
    Vec3 result(0.0);
    bool good = found != json.end() && found->is_array() && found->size() == 3;
    for (int i = 0; good && i < 3; ++i) {
      good = (*found)[i].is_number();
      if (good) result[i] = (*found)[i].get<double>();
      good = good && std::isfinite(result[i]);
    }
    if (good) return result;
    return Error("\"{}\" must be three numbers, like [0, 1, 0]", key);
  }

  Result<Vec3> Direction(const char* key) const {
    ASSIGN_OR_RETURN(const Vec3 v, Vector(key));
    const double length = glm::length(v);
    if (length > 1e-150 && length < 1e150) return v / length;
    return Error("\"{}\" has no length; give it one", key);
  }

  Result<std::string> Text(const char* key) const {
    const auto found = json.find(key);
    if (found != json.end() && found->is_string()) return found->get<std::string>();
    return Error("\"{}\" must be a text", key);
  }

  // Three numbers, or one for all channels; where the key is not there `missing`, if that is given.
  Result<Rgb> Colour(const char* key, std::optional<Rgb> missing = {}) const {
    constexpr double kMost = 1e30;
    if (missing && !json.contains(key)) return *missing;
    if (const auto found = json.find(key); found != json.end() && found->is_number()) {
      ASSIGN_OR_RETURN(const double value, Number(key, {}, 0, kMost));
      return Rgb(value);
    }
    const Result<Vec3> colour = Vector(key);
    bool good = colour.has_value();
    for (int c = 0; good && c < 3; ++c) good = (*colour)[c] >= 0 && (*colour)[c] <= kMost;
    if (good) return *colour;
    return Error("\"{}\" must be 0 or more, one number or three", key);
  }
};

}  // namespace isolux
