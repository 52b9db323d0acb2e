// What of a scene's bytes tells of translucent sheets: the diffuse transmittances of materials,
// behind all else and only where there are some.
#pragma once

#include "common/scene/scene.h"
#include "common/util/bytes.h"

namespace isolux {

inline constexpr uint64_t kSheetsMagic = 0x3145485358554c49ULL;  // "ILUXSHE1": what follows

void PutSheets(ByteWriter& out, const Scene& scene);
// The magic number comes next.
Status TakeSheets(ByteReader& in, Scene* scene);

// Whether the polygon passes light on from either side to the other: its material does, and both
// sides take part.
bool IsSheet(const Scene& scene, const Polygon& polygon);

}  // namespace isolux
