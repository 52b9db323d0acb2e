#include "common/scene/solve_options.h"

#include <cmath>

#include "common/scene/effects_choice.h"

namespace isolux {
namespace {

constexpr uint32_t kMostRounds = 256;
constexpr uint32_t kLargestCut = 65'536;

template <typename... Args>
Status Invalid(fmt::format_string<Args...> format, Args&&... args) {
  return MakeStatus(StatusCode::kInvalidArgument, format, std::forward<Args>(args)...);
}

}  // namespace

Status SolveOptions::Validate() const {
  if (!(accuracy > 0 && accuracy <= 1)) {
    return Invalid("accuracy {} is outside (0, 1]; 0.02 asks for 2 %", accuracy);
  }
  if (!(max_seconds >= 0 && std::isfinite(max_seconds))) {
    return Invalid("max_seconds {} is not a time; 0 means no limit", max_seconds);
  }
  if (max_rounds < 1 || max_rounds > kMostRounds) {
    return Invalid("max_rounds {} is outside 1 to {}", max_rounds, kMostRounds);
  }
  if (cut_size < 1 || cut_size > kLargestCut) {
    return Invalid("cut_size {} is outside 1 to {}", cut_size, kLargestCut);
  }
  if (forced_splits > kLargestCut) {
    return Invalid("forced_splits {} is more than {}", forced_splits, kLargestCut);
  }
  if (!(balance_threshold >= 1 && std::isfinite(balance_threshold))) {
    return Invalid("balance_threshold {} is below 1, which no load can reach", balance_threshold);
  }
  if (epsilons.size() > kMostRounds) {
    return Invalid("{} epsilons, more than {} rounds", epsilons.size(), kMostRounds);
  }
  double last = HUGE_VAL;
  for (const double epsilon : epsilons) {
    if (!(epsilon > 0 && std::isfinite(epsilon) && epsilon <= last)) {
      return Invalid("epsilon {} is not a positive power in W, or is larger than the one before",
                     epsilon);
    }
    last = epsilon;
  }
  RETURN_IF_ERROR(ParseEffectsChoice(effects));
  return {};
}

const char* ToText(EndReason reason) {
  switch (reason) {
    case EndReason::kAccuracy:
      return "accuracy reached";
    case EndReason::kSeconds:
      return "time budget used";
    case EndReason::kLinks:
      return "link budget used";
    case EndReason::kMemory:
      return "memory budget used";
    case EndReason::kRounds:
      return "all rounds done";
    case EndReason::kPrecision:
      return "limit of precision reached";
    case EndReason::kFinished:
      return "finished on request";
  }
  return "unknown";
}

Result<Distribution> ParseDistribution(const std::string& text) {
  if (text == "octree") return Distribution::kOctree;
  if (text == "random") return Distribution::kRandom;
  if (text == "input") return Distribution::kInput;
  if (text == "balanced") return Distribution::kBalanced;
  return Error(StatusCode::kInvalidArgument,
               "distribution '{}': choose octree, random, input or balanced", text);
}

Result<BalanceStrategy> ParseBalanceStrategy(const std::string& text) {
  if (text == "none") return BalanceStrategy::kNone;
  if (text == "rotate") return BalanceStrategy::kRotate;
  if (text == "greedy-refine") return BalanceStrategy::kGreedyRefine;
  return Error(StatusCode::kInvalidArgument,
               "balance strategy '{}': choose none, rotate or greedy-refine", text);
}

Result<SolverMethod> ParseSolverMethod(const std::string& text) {
  for (int m = 0; m <= static_cast<int>(SolverMethod::kSouthwell); ++m) {
    if (text == ToText(static_cast<SolverMethod>(m))) return static_cast<SolverMethod>(m);
  }
  return Error(StatusCode::kInvalidArgument,
               "solver '{}': choose cg, jacobi, gauss-seidel, chebyshev or southwell", text);
}

const char* ToText(SolverMethod method) {
  switch (method) {
    case SolverMethod::kConjugateGradients:
      return "cg";
    case SolverMethod::kJacobi:
      return "jacobi";
    case SolverMethod::kGaussSeidel:
      return "gauss-seidel";
    case SolverMethod::kChebyshev:
      return "chebyshev";
    case SolverMethod::kSouthwell:
      return "southwell";
  }
  return "unknown";
}

}  // namespace isolux
