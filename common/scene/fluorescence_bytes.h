// What of a scene's bytes tells of fluorescence: the reradiation of materials, behind all else and
// only where there is some.
#pragma once

#include "common/scene/scene.h"
#include "common/util/bytes.h"

namespace isolux {

inline constexpr uint64_t kFluorescenceMagic = 0x31554c4658554c49ULL;  // "ILUXFLU1": what follows

void PutFluorescence(ByteWriter& out, const Scene& scene);
// The magic number comes next.
Status TakeFluorescence(ByteReader& in, Scene* scene);

}  // namespace isolux
