// Before the output is gathered, so are the sources it is gathered from: what leaves reflect is
// then as good as what is gathered from them (docs/design.md, "Gather and output").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/hierarchy/hierarchy.h"
#include "common/hierarchy/snapshot.h"
#include "server/crew.h"
#include "server/gather_waves.h"
#include "server/output_mesh.h"

namespace isolux {

// Whether anything but what leaves emit is gathered from them.
bool HasGatheredSources(const EffectsPlan& plan, const OutputMeshOptions& output);

// Places in the snapshot, in order, of the leaves that reflect most: all but a tenth of the
// accuracy of what all reflect. The rest may be most of all leaves. What sheets pass on and what is
// reradiated counts as reflected.
std::vector<uint32_t> LeavesThatReflectMost(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                            const OutputMeshOptions& output);

// Scales, channel by channel, what was gathered so that all leaves reflect as much as they do in
// the solution: that keeps all power, while points at the middles lose some (docs/design.md). By no
// more than a quarter. `gathered`: the snapshot with other irradiance at some leaves.
void KeepReflectedPower(const Hierarchy& hierarchy, const OutputMeshOptions& output,
                        const Snapshot& solution, std::span<const uint32_t> leaves,
                        Snapshot* gathered);

// Light that the links missed. Over a region, here the lowest clusters of the octree, what is
// gathered at the middles of leaves is off from the solution one way here and the other there, as
// middles are from means and as rays will have it; where all of a region is off one way, the
// solution is. Of the sum of a region, Σ d, what is beyond such chance is √((Σ d)² − Σ d²).
struct UnseenLight {
  double error = 0;      // of the output, of its mean irradiance
  uint32_t polygon = 0;  // of the scene file, that has most of it
};
UnseenLight FindUnseenLight(const Hierarchy& hierarchy, const OutputMeshOptions& output,
                            const Snapshot& solution, std::span<const uint32_t> leaves,
                            const Snapshot& gathered);

// Puts what is gathered at the middles of these leaves in the place of what the solution has for
// them, at the workers, for the output alone.
Result<UnseenLight> GatherSources(Crew& crew, const Hierarchy& hierarchy, const Snapshot& snapshot,
                                  const OutputMeshOptions& output, GatherWaves& waves);

}  // namespace isolux
