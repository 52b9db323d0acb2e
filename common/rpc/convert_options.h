// SolveOptions, and what was measured of effects, to protocol messages and back; shared by the job
// and the worker services.
#pragma once

#include <span>
#include <vector>

#include "common/scene/solve_options.h"
#include "common/util/status.h"
#include "isolux/v1/solve_options.pb.h"

namespace isolux {

v1::SolveOptions ToProto(const SolveOptions& options);

// Checks only what a struct cannot hold (unknown enumerators); SolveOptions::Validate does the
// rest.
Result<SolveOptions> FromProto(const v1::SolveOptions& message);

void PutMeasured(std::span<const MeasuredEffect> measured,
                 google::protobuf::RepeatedPtrField<v1::MeasuredEffect>* effects);
// No more than there are effects, each known and with numbers that may be.
Result<std::vector<MeasuredEffect>> TakeMeasured(
    const google::protobuf::RepeatedPtrField<v1::MeasuredEffect>& effects);

void PutCosts(const EffectCosts& costs, google::protobuf::RepeatedPtrField<v1::EffectCost>* list);
// The same of costs.
Result<EffectCosts> TakeCosts(const google::protobuf::RepeatedPtrField<v1::EffectCost>& list);

}  // namespace isolux
