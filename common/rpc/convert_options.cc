#include "common/rpc/convert_options.h"

#include <cmath>
#include <utility>

#include "common/scene/effects_choice.h"

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

void PutMeasured(std::span<const MeasuredEffect> measured,
                 google::protobuf::RepeatedPtrField<v1::MeasuredEffect>* effects) {
  for (const MeasuredEffect& effect : measured) {
    v1::MeasuredEffect* message = effects->Add();
    message->set_name(effect.name);
    message->set_share(effect.share);
    message->set_amplification(effect.amplification);
    if (effect.bound) message->set_bound(*effect.bound);
    message->set_off(effect.off);
  }
}

Result<std::vector<MeasuredEffect>> TakeMeasured(
    const google::protobuf::RepeatedPtrField<v1::MeasuredEffect>& effects) {
  if (effects.size() > static_cast<int>(kSwitchableEffects.size())) {
    return Error(StatusCode::kDataLoss, "{} measured effects; {} is the limit", effects.size(),
                 kSwitchableEffects.size());
  }
  std::vector<MeasuredEffect> measured;
  for (const v1::MeasuredEffect& message : effects) {
    MeasuredEffect effect{.name = message.name(),
                          .share = message.share(),
                          .amplification = message.amplification(),
                          .off = message.off()};
    if (message.has_bound()) effect.bound = message.bound();
    RETURN_IF_ERROR(Validate(effect));
    measured.push_back(std::move(effect));
  }
  return measured;
}

void PutCosts(const EffectCosts& costs, google::protobuf::RepeatedPtrField<v1::EffectCost>* list) {
  for (size_t i = 0; i < EffectCosts::kCount; ++i) {
    const EffectCost& cost = costs.at(i);
    if (cost == EffectCost()) continue;
    v1::EffectCost* message = list->Add();
    message->set_effect(static_cast<uint32_t>(i));
    message->set_cpu_s(cost.cpu_s);
    message->set_rays(cost.rays);
    message->set_links(cost.links);
  }
}

Result<EffectCosts> TakeCosts(const google::protobuf::RepeatedPtrField<v1::EffectCost>& list) {
  if (list.size() > static_cast<int>(EffectCosts::kCount)) {
    return Error(StatusCode::kDataLoss, "costs of {} effects; there are {}", list.size(),
                 EffectCosts::kCount);
  }
  EffectCosts costs;
  for (const v1::EffectCost& message : list) {
    if (message.effect() >= EffectCosts::kCount || !(message.cpu_s() >= 0) ||
        std::isinf(message.cpu_s())) {
      return Error(StatusCode::kDataLoss, "costs: {} s of effect {}", message.cpu_s(),
                   message.effect());
    }
    costs.at(message.effect()) = {message.cpu_s(), message.rays(), message.links()};
  }
  return costs;
}

}  // namespace isolux
