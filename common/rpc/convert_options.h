// SolveOptions to its protocol message and back; shared by the job and the worker services.
#pragma once

#include "common/scene/solve_options.h"
#include "common/util/status.h"
#include "isolux/v1/solve_options.pb.h"

namespace isolux {

v1::SolveOptions ToProto(const SolveOptions& options);

// Checks only what a struct cannot hold (unknown enumerators); SolveOptions::Validate does the
// rest.
Result<SolveOptions> FromProto(const v1::SolveOptions& message);

}  // namespace isolux
