#include "worker/radiosity/shut_out.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/util/random.h"

namespace isolux {
namespace {

constexpr int kPackets = 8;

// One of all directions alike, by rejection, as cosine-distributed ones are drawn.
Vec3 AnyDirection(Random& random) {
  while (true) {
    const double x = 2 * random.Unit() - 1, y = 2 * random.Unit() - 1, z = 2 * random.Unit() - 1;
    const double square = x * x + y * y + z * z;
    if (square > 1e-6 && square < 1) return Vec3(x, y, z) / std::sqrt(square);
  }
}

}  // namespace

std::vector<std::vector<uint32_t>> ClosedComponentsLit(const Hierarchy& hierarchy,
                                                       const RayScene& rays, const Scout& scout,
                                                       uint64_t seed) {
  const Scene& scene = hierarchy.scene();
  std::vector<std::vector<uint32_t>> lit(scene.lights.size());
  std::vector<std::array<uint32_t, 2>> surface_of(scene.polygons.size());
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    surface_of[surface.polygon][static_cast<int>(surface.side)] = s;
  }
  Random random(Hash(seed, 0x5007u));
  for (size_t l = 0; l < lit.size(); ++l) {
    if (scene.lights[l].kind == LightKind::kDirectional) continue;
    for (int k = 0; k < kPackets; ++k) {
      std::array<Escape, RayScene::kPacket> escapes;
      // Rays do not meet the polygon they leave: by turns two of which the light is on neither.
      const auto left = static_cast<uint32_t>(k % 2 == 0 ? 0 : scene.polygons.size() - 1);
      for (Escape& ray : escapes) ray = {scene.lights[l].position_m, AnyDirection(random), left};
      for (const RayHit& hit : rays.Trace(escapes, RayScene::kPacket)) {
        if (!TakesPart(scene, hit)) continue;
        const uint32_t surface = surface_of[hit.polygon][static_cast<int>(hit.side)];
        if (scout.closed[surface] != 0) lit[l].push_back(scout.component[surface]);
      }
    }
    std::ranges::sort(lit[l]);
    lit[l].erase(std::unique(lit[l].begin(), lit[l].end()), lit[l].end());
  }
  return lit;
}

}  // namespace isolux
