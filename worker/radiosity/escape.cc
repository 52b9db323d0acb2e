#include "worker/radiosity/escape.h"

#include <algorithm>
#include <cmath>

#include "common/util/disjoint_sets.h"
#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/openings.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {
namespace {

// Over the whole scene, half of them in proportion to area, half to emitted power.
constexpr double kScoutRays = 131072;
constexpr double kPowerRays = 16384;  // over all leaves, in proportion to power
constexpr double kClosedRays = 15;    // times 1/(a (1 − ρ̄)): see the header
// Of a component that absorbs less than this at a bounce, at most.
constexpr double kMagnifiesMuch = 0.05, kMostRays = 1 << 22;

// A packet of cosine-distributed rays from points of a polygon.
std::array<Escape, RayScene::kPacket> CosineRays(const ConvexPolygon& polygon, uint32_t source,
                                                 Random& random) {
  const Vec3 n = polygon.Normal();
  const Vec3 helper = std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 s = glm::normalize(glm::cross(n, helper));
  const Vec3 t = glm::cross(n, s);
  std::array<Escape, RayScene::kPacket> rays;
  for (Escape& ray : rays) {
    // A uniform point of the unit disk, raised to the hemisphere (Malley); by rejection, since the
    // C library's sine differs between machines.
    double x = 0, y = 0;
    do {
      x = 2 * random.Unit() - 1;
      y = 2 * random.Unit() - 1;
    } while (x * x + y * y >= 1);
    const double height = std::sqrt(std::max(1e-12, 1 - x * x - y * y));
    const double u = random.Unit();
    ray = {SamplePolygon(polygon, u, random.Unit()), x * s + y * t + height * n, source};
  }
  return rays;
}

uint8_t SideFlag(Side side) {
  return side == Side::kFront ? kFrontTakesPart | kFrontEmits : kBackTakesPart | kBackEmits;
}

struct Scouted {
  uint32_t rays = 0;
  uint32_t escaped = 0;
  double lost = 0;            // of the rays' light, mirrors followed
  std::vector<uint32_t> met;  // surfaces
};

}  // namespace

bool TakesPart(const Scene& scene, const RayHit& hit) {
  return hit.polygon != RayHit::kNothing &&
         (scene.polygons[hit.polygon].sides & SideFlag(hit.side)) != 0;
}

namespace {

// Casts rays and counts what becomes of them.
class Scouting {
 public:
  Scouting(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
           const TranslucentSheets& sheets, uint64_t seed, ThreadPool& pool)
      : hierarchy_(hierarchy),
        rays_(rays),
        mirrors_(mirrors),
        sheets_(sheets),
        seed_(seed),
        pool_(pool),
        surface_of_(hierarchy.scene().polygons.size()),
        scouted_(hierarchy.surfaces().size()),
        components_(scouted_.size()) {
    for (uint32_t s = 0; s < scouted_.size(); ++s) {
      const Surface& surface = hierarchy.surfaces()[s];
      surface_of_[surface.polygon][static_cast<int>(surface.side)] = s;
    }
  }

  DisjointSets& components() { return components_; }

  void CastOverAll() {
    const double total_area = hierarchy_.clusters()[0].area_m2;
    const double total_power = Sum(hierarchy_.emitted_w());
    Cast(0x5c0u, [&](uint32_t s) {
      const double area = hierarchy_.surface_area_m2(s);
      const double power =
          total_power > 0 ? area * Sum(hierarchy_.surfaces()[s].exitance) / total_power : 0.0;
      const double share = 0.5 * (area / total_area + power);
      return std::clamp(static_cast<int>(kScoutRays / RayScene::kPacket * share), 2, 4096);
    });
  }

  // More rays where none has left, but so much is reflected that few are not enough to say so.
  void CastWhereMuchIsMagnified(double accuracy) {
    const std::vector<Pool> pools = Pools();
    Cast(0x5c1u, [&](uint32_t s) {
      const Pool& p = pools[components_.Find(s)];
      if (p.escaped > 0 || p.Absorbed() > kMagnifiesMuch) return 0;
      const double wanted = std::min(kClosedRays / (accuracy * p.Absorbed()), kMostRays);
      const double lacking = std::max(0.0, wanted - static_cast<double>(p.rays));
      const double share = hierarchy_.surface_area_m2(s) / p.area;
      return static_cast<int>(std::ceil(lacking / RayScene::kPacket * share));
    });
  }

  Scout Told(double accuracy) {
    const std::vector<Pool> pools = Pools();
    Scout scout;
    for (uint32_t s = 0; s < scouted_.size(); ++s) {
      const uint32_t component = components_.Find(s);
      const Pool& p = pools[component];
      const auto rays = static_cast<double>(p.rays);
      const bool closed = p.escaped == 0 && rays * accuracy * p.Absorbed() >= kClosedRays;
      const bool unproven = p.escaped == 0 && !closed;
      scout.component.push_back(component);
      scout.rays.push_back(scouted_[s].rays);
      scout.escape.push_back(static_cast<float>(scouted_[s].lost) /
                             static_cast<float>(scouted_[s].rays));
      scout.closed.push_back(closed ? 1 : 0);
      scout.unseen_openings.push_back(unproven ? static_cast<float>(1 / (rays * p.Absorbed()))
                                               : 0.0F);
    }
    return scout;
  }

 private:
  // Of a component.
  struct Pool {
    uint64_t rays = 0, escaped = 0;
    double area = 0, reflecting = 0;

    double Absorbed() const { return std::max(1e-6, 1 - reflecting / area); }
  };

  std::vector<Pool> Pools() {
    std::vector<Pool> pools(scouted_.size());
    for (uint32_t s = 0; s < scouted_.size(); ++s) {
      Pool& p = pools[components_.Find(s)];
      const Rgb rho = hierarchy_.surfaces()[s].reflectance + sheets_.TransmittanceOf(s);
      p.rays += scouted_[s].rays;
      p.escaped += scouted_[s].escaped;
      p.area += hierarchy_.surface_area_m2(s);
      p.reflecting += hierarchy_.surface_area_m2(s) * std::max({rho.x, rho.y, rho.z});
    }
    return pools;
  }

  // packets_of(surface) rays of each surface; then joins those that see each other.
  template <typename PacketsOf>
  void Cast(uint32_t stream, const PacketsOf& packets_of) {
    std::vector<int> packets(scouted_.size());
    for (uint32_t s = 0; s < packets.size(); ++s) packets[s] = packets_of(s);
    pool_.For(scouted_.size(), 64, [&](size_t begin, size_t end, int) {
      for (size_t s = begin; s < end; ++s) {
        Random random(Hash(seed_, stream, s));
        for (int k = 0; k < packets[s]; ++k) CastPacket(s, random);
      }
    });
    for (uint32_t s = 0; s < scouted_.size(); ++s) {
      for (const uint32_t met : scouted_[s].met) components_.Join(s, met);
      scouted_[s].met.clear();
    }
  }

  void CastPacket(size_t s, Random& random) {
    const auto escapes = CosineRays(DrawnIn(hierarchy_.geometry(s), rays_.coordinate_noise_m()),
                                    hierarchy_.surfaces()[s].polygon, random);
    const auto hits = rays_.Trace(escapes, RayScene::kPacket);
    Scouted& scouted = scouted_[s];
    for (int i = 0; i < RayScene::kPacket; ++i) {
      const RayHit& hit = hits[i];
      ++scouted.rays;
      scouted.lost += EscapedShare(rays_, mirrors_, escapes[i], hit, hierarchy_);
      if (TakesPart(hierarchy_.scene(), hit)) {
        scouted.met.push_back(surface_of_[hit.polygon][static_cast<int>(hit.side)]);
      } else {
        ++scouted.escaped;
      }
    }
  }

  const Hierarchy& hierarchy_;
  const RayScene& rays_;
  const Mirrors& mirrors_;
  const TranslucentSheets& sheets_;
  uint64_t seed_;
  ThreadPool& pool_;
  std::vector<std::array<uint32_t, 2>> surface_of_;  // of a polygon's sides
  std::vector<Scouted> scouted_;                     // by surface
  DisjointSets components_;
};

}  // namespace

Scout ScoutEscapes(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const TranslucentSheets& sheets, double accuracy, uint64_t seed,
                   ThreadPool& pool) {
  Scouting scouting(hierarchy, rays, mirrors, sheets, seed, pool);
  scouting.CastOverAll();
  JoinPastFreeEdges(hierarchy, rays, seed, pool, &scouting.components());
  scouting.CastWhereMuchIsMagnified(accuracy);
  return scouting.Told(accuracy);
}

int EscapeRaysOf(double share_of_power) {
  const double packets = std::round(kPowerRays / RayScene::kPacket * share_of_power);
  return RayScene::kPacket * std::max(kEscapeRays / RayScene::kPacket, static_cast<int>(packets));
}

double EscapeShare(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const NodeId& id, const ConvexPolygon& polygon, double prior, int ray_count,
                   uint64_t seed) {
  Random random(Hash(seed, 0xe5c0u, Hash(id.surface, id.path)));
  double escaped = 0;
  for (int k = 0; k < ray_count / RayScene::kPacket; ++k) {
    const auto escapes = CosineRays(DrawnIn(polygon, rays.coordinate_noise_m()),
                                    hierarchy.surfaces()[id.surface].polygon, random);
    const auto hits = rays.Trace(escapes, RayScene::kPacket);
    for (int i = 0; i < RayScene::kPacket; ++i) {
      escaped += EscapedShare(rays, mirrors, escapes[i], hits[i], hierarchy);
    }
  }
  return (escaped + kPriorRays * prior) / (ray_count + kPriorRays);
}

double EscapeDeviation(double share, double ray_count) {
  const double v = (share * ray_count + 0.5) / (ray_count + 1);
  return std::sqrt(v * (1 - v) / ray_count);
}

}  // namespace isolux
