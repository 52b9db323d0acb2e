#include "common/rpc/convert_options.h"

namespace isolux {

v1::SolveOptions ToProto(const SolveOptions& options) {
  v1::SolveOptions message;
  message.set_accuracy(options.accuracy);
  message.set_max_seconds(options.max_seconds);
  message.set_max_links(options.max_links);
  message.set_max_memory_bytes(options.max_memory_bytes);
  message.set_max_rounds(options.max_rounds);
  message.set_cut_size(options.cut_size);
  message.set_forced_splits(options.forced_splits);
  message.set_distribution(static_cast<v1::Distribution>(options.distribution));
  message.set_balance(static_cast<v1::BalanceStrategy>(options.balance));
  message.set_balance_threshold(options.balance_threshold);
  message.mutable_epsilons()->Assign(options.epsilons.begin(), options.epsilons.end());
  message.set_seed(options.seed);
  message.set_solver(static_cast<v1::SolverMethod>(options.solver));
  message.set_effects(options.effects);
  return message;
}

Result<SolveOptions> FromProto(const v1::SolveOptions& message) {
  if (!v1::Distribution_IsValid(message.distribution())) {
    return Error(StatusCode::kInvalidArgument, "options: unknown distribution {}",
                 static_cast<int>(message.distribution()));
  }
  if (!v1::BalanceStrategy_IsValid(message.balance())) {
    return Error(StatusCode::kInvalidArgument, "options: unknown balance strategy {}",
                 static_cast<int>(message.balance()));
  }
  if (!v1::SolverMethod_IsValid(message.solver())) {
    return Error(StatusCode::kInvalidArgument, "options: unknown solver {}",
                 static_cast<int>(message.solver()));
  }
  SolveOptions options;
  options.accuracy = message.accuracy();
  options.max_seconds = message.max_seconds();
  options.max_links = message.max_links();
  options.max_memory_bytes = message.max_memory_bytes();
  options.max_rounds = message.max_rounds();
  options.cut_size = message.cut_size();
  options.forced_splits = message.forced_splits();
  options.distribution = static_cast<Distribution>(message.distribution());
  options.balance = static_cast<BalanceStrategy>(message.balance());
  options.balance_threshold = message.balance_threshold();
  options.epsilons.assign(message.epsilons().begin(), message.epsilons().end());
  options.seed = message.seed();
  options.solver = static_cast<SolverMethod>(message.solver());
  if (!message.effects().empty()) options.effects = message.effects();
  return options;
}

}  // namespace isolux
