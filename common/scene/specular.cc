#include "common/scene/specular.h"

#include <algorithm>

namespace isolux {

void PutMirrors(ByteWriter& out, const Scene& scene) {
  const auto count = static_cast<uint64_t>(std::ranges::count_if(
      scene.materials, [](const Material& material) { return material.specular != 0; }));
  if (count == 0) return;
  out.Put(kMirrorsMagic);
  out.Put(count);
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    if (scene.materials[m].specular == 0) continue;
    out.Put(static_cast<uint64_t>(m));
    out.Put(scene.materials[m].specular);
  }
}

Status TakeMirrors(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();
  const auto count = in.Get<uint64_t>();
  uint64_t least = 0;
  for (uint64_t i = 0; i < count && in.ok(); ++i) {
    const auto m = in.Get<uint64_t>();
    const auto share = in.Get<double>();
    if (!in.ok() || m < least || m >= scene->materials.size() || !(share > 0 && share <= 1)) break;
    scene->materials[m].specular = share;
    least = m + 1;
    if (i + 1 == count) return {};
  }
  return MakeStatus(StatusCode::kDataLoss, "scene: its mirrors are missing, or none");
}

}  // namespace isolux
