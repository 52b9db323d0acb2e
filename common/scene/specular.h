// What of a scene's bytes tells of mirrors: the specular shares of materials, behind all else and
// only where there are some.
#pragma once

#include "common/scene/scene.h"
#include "common/util/bytes.h"

namespace isolux {

inline constexpr uint64_t kMirrorsMagic = 0x3152494d58554c49ULL;  // "ILUXMIR1": what follows

void PutMirrors(ByteWriter& out, const Scene& scene);
// The magic number comes next.
Status TakeMirrors(ByteReader& in, Scene* scene);

}  // namespace isolux
