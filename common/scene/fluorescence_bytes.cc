#include "common/scene/fluorescence_bytes.h"

#include <algorithm>

namespace isolux {

void PutFluorescence(ByteWriter& out, const Scene& scene) {
  const auto count = static_cast<uint64_t>(std::ranges::count_if(
      scene.materials, [](const Material& m) { return m.reradiation.exists(); }));
  if (count == 0) return;
  out.Put(kFluorescenceMagic);
  out.Put(count);
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    const Reradiation& reradiation = scene.materials[m].reradiation;
    if (!reradiation.exists()) continue;
    out.Put(static_cast<uint64_t>(m));
    out.Put(reradiation.blue_to_green);
    out.Put(reradiation.blue_to_red);
    out.Put(reradiation.green_to_red);
  }
}

Status TakeFluorescence(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();
  const auto count = in.Get<uint64_t>();
  uint64_t least = 0;
  for (uint64_t i = 0; i < count && in.ok(); ++i) {
    const auto m = in.Get<uint64_t>();
    Reradiation reradiation;
    reradiation.blue_to_green = in.Get<double>();
    reradiation.blue_to_red = in.Get<double>();
    reradiation.green_to_red = in.Get<double>();
    if (!in.ok() || m < least || m >= scene->materials.size() || !reradiation.exists()) break;
    scene->materials[m].reradiation = reradiation;
    least = m + 1;
    if (i + 1 == count) return {};
  }
  return MakeStatus(StatusCode::kDataLoss, "scene: its fluorescence is missing, or none");
}

}  // namespace isolux
