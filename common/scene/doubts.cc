#include "common/scene/doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace isolux {
namespace {

constexpr double kRules = 0.5;      // share of the estimate
constexpr double kManyLeaks = 0.1;  // share of the area

struct Part {
  double error = 0;
  std::string words;
};

}  // namespace

std::vector<std::string> DoubtsOf(const SolveSummary& summary) {
  if (summary.rounds.empty()) return {};
  const RoundSummary& last = summary.rounds.back();
  std::vector<Part> parts{
      {last.error_unseen,
       fmt::format("light that links missed and the gather found, most about polygon {}: lamps or "
                   "gaps smaller than the elements about them; a finer accuracy finds more",
                   last.unseen_polygon)},
      {last.error_visibility,
       "visibility: links of which some rays are blocked, such as of a small light seen through a "
       "small gap"},
      {last.error_spread,
       "variation of sources: bright spots smaller than the elements, such as above lamps"},
      {last.error_coupling, "coupling: groups of polygons that exchange light as wholes"},
      {last.error_closure,
       "rows that do not add up: gaps between polygons, or light that leaves where none should"},
      {last.error_solver, "what is not followed: unfinished iteration, or effects left out"},
      {last.error_interpolation,
       "what lies between output points: edges of shadows and of light close to its source"}};
  std::erase_if(parts,
                [&](const Part& part) { return !(part.error > kRules * last.error_estimate); });
  std::ranges::stable_sort(parts, std::greater(), &Part::error);
  std::vector<std::string> doubts;
  for (const Part& part : parts) {
    doubts.push_back(fmt::format("{:.2g} %: {}", 100 * part.error, part.words));
  }
  if (last.leak_area > kManyLeaks) {
    doubts.push_back(
        fmt::format("{:.2g} % of the area leaks or lacks links: polygons that cross, "
                    "or gaps between them",
                    100 * last.leak_area));
  }
  return doubts;
}

}  // namespace isolux
