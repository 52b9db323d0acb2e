// The output of a job, once its rounds have stopped: gathers the sources, which may show that the
// rounds are to go on, then the mesh, then the spectral bands.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "common/hierarchy/assignment.h"
#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "common/scene/effects_plan.h"
#include "common/scene/patch_file.h"
#include "common/scene/solve_options.h"
#include "server/band_solve.h"
#include "server/crew.h"
#include "server/gather_waves.h"
#include "server/output_mesh.h"

namespace isolux {

struct OutputNews {
  std::function<void(uint64_t gathered)> gathering;  // elements so far
  BandNews bands;
};

// Of one snapshot and the workers there are. What it is given must outlive it.
class JobOutput {
 public:
  // `batch`: elements asked for at once.
  JobOutput(Crew& crew, const Hierarchy& hierarchy, const EffectsPlan& plan,
            const Snapshot& snapshot, OutputMeshOptions options, uint32_t batch);

  // Puts gathered sources in the place of the snapshot at the workers, and says in the row what
  // light of them the links have missed. Nothing where light is not reflected.
  Status GatherSources(RoundSummary* row);

  // Where rounds go on: puts the snapshot back. What was done here is the row's.
  Status Drop(const std::string& encoded_snapshot, RoundSummary* row);

  // After GatherSources. Completes the summary: its last row and all that it says of the gather.
  // `accuracy`: asked for.
  Result<PatchFile> Make(const Assignment& assignment, double accuracy, const OutputNews& news,
                         SolveSummary* summary);

 private:
  double Seconds() const;

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  Crew& crew_;
  const Hierarchy& hierarchy_;
  const EffectsPlan& plan_;
  const Snapshot& snapshot_;
  const OutputMeshOptions options_;
  GatherWaves waves_;
};

}  // namespace isolux
