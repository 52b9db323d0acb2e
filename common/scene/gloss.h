// What of a scene's bytes tells of glossy materials: the shares of their lobes, behind all else and
// only where there are some.
#pragma once

#include "common/scene/scene.h"
#include "common/util/bytes.h"

namespace isolux {

inline constexpr uint64_t kGlossMagic = 0x314f4c4758554c49ULL;  // "ILUXGLO1": what follows

void PutGloss(ByteWriter& out, const Scene& scene);
// The magic number comes next.
Status TakeGloss(ByteReader& in, Scene* scene);

}  // namespace isolux
