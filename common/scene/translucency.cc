#include "common/scene/translucency.h"

#include <algorithm>

namespace isolux {

void PutSheets(ByteWriter& out, const Scene& scene) {
  const auto count = static_cast<uint64_t>(std::ranges::count_if(
      scene.materials, [](const Material& m) { return m.transmittance != Rgb(0.0); }));
  if (count == 0) return;
  out.Put(kSheetsMagic);
  out.Put(count);
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    const Rgb& passed = scene.materials[m].transmittance;
    if (passed == Rgb(0.0)) continue;
    out.Put(static_cast<uint64_t>(m));
    for (int c = 0; c < 3; ++c) out.Put(passed[c]);
  }
}

Status TakeSheets(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();
  const auto count = in.Get<uint64_t>();
  uint64_t least = 0;
  for (uint64_t i = 0; i < count && in.ok(); ++i) {
    const auto m = in.Get<uint64_t>();
    Rgb passed(0.0);
    for (int c = 0; c < 3; ++c) passed[c] = in.Get<double>();
    if (!in.ok() || m < least || m >= scene->materials.size() || passed == Rgb(0.0)) break;
    scene->materials[m].transmittance = passed;
    least = m + 1;
    if (i + 1 == count) return {};
  }
  return MakeStatus(StatusCode::kDataLoss, "scene: its translucent sheets are missing, or none");
}

bool IsSheet(const Scene& scene, const Polygon& polygon) {
  constexpr uint8_t kBoth = kFrontTakesPart | kBackTakesPart;
  return (polygon.sides & kBoth) == kBoth &&
         scene.materials[polygon.material].transmittance != Rgb(0.0);
}

}  // namespace isolux
