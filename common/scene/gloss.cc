#include "common/scene/gloss.h"

#include <algorithm>

namespace isolux {

void PutGloss(ByteWriter& out, const Scene& scene) {
  const auto count = static_cast<uint64_t>(
      std::ranges::count_if(scene.materials, [](const Material& m) { return m.gloss.exists(); }));
  if (count == 0) return;
  out.Put(kGlossMagic);
  out.Put(count);
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    const Gloss& gloss = scene.materials[m].gloss;
    if (!gloss.exists()) continue;
    out.Put(static_cast<uint64_t>(m));
    for (int c = 0; c < 3; ++c) out.Put(gloss.share[c] + 0.0);
    out.Put(static_cast<uint8_t>(gloss.kept ? 1 : 0));
  }
}

Status TakeGloss(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();
  const auto count = in.Get<uint64_t>();
  uint64_t least = 0;
  for (uint64_t i = 0; i < count && in.ok(); ++i) {
    const auto m = in.Get<uint64_t>();
    Gloss gloss;
    for (int c = 0; c < 3; ++c) gloss.share[c] = in.Get<double>();
    const auto kept = in.Get<uint8_t>();
    gloss.kept = kept == 1;
    if (!in.ok() || m < least || m >= scene->materials.size() || !gloss.exists() || kept > 1) break;
    scene->materials[m].gloss = gloss;
    least = m + 1;
    if (i + 1 == count) return {};
  }
  return MakeStatus(StatusCode::kDataLoss, "scene: its glossy materials are missing, or none");
}

}  // namespace isolux
