// A patch file of a job that still runs: the newest snapshot as it is, for who wants to look at
// once.
#pragma once

#include "common/hierarchy/snapshot.h"
#include "common/rpc/job_info.h"
#include "common/scene/patch_file.h"
#include "common/scene/scene.h"

namespace isolux {

// The leaves with their mean irradiance, its corners the means of what meets there; nothing is
// gathered, so that neither the workers nor the job hear of it. What a leaf hides of the variation
// within it is added to its error (in squares; an even slope of range r is off by r/4 on average),
// and the error estimate of the comments is that of these constants. Comments `latest_round`,
// `gathered` and `error_estimate_gathered` say what it is; spectral bands, which are solved for
// once the rounds are over, are left out, and `bands_left_out` says so. `job` has the rounds up to
// the snapshot's.
Result<PatchFile> BuildLatest(const Scene& scene, const Snapshot& snapshot, const JobInfo& job);

}  // namespace isolux
