#include "worker/radiosity/light_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "common/hierarchy/effects/detectors.h"
#include "common/util/angles.h"
#include "common/util/random.h"
#include "worker/coupling/lanes.h"
#include "worker/radiosity/disc_grid.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/polygon_seen.h"
#include "worker/radiosity/shut_out.h"

namespace isolux {
namespace {

constexpr int kSamples = 16;  // of an element: two packets of rays
// What rays that all agree may still have missed: deviation of visibility. As that of links, whose
// eight rays have 0.3, halved for each doubling of their number beyond.
constexpr double kUnseen = 0.1;
// Of the light that is partly hidden from a leaf: output elements are a quarter of it in size
// (server/output_mesh.h), a border runs through four in sixteen, and interpolation is off by a
// quarter there.
constexpr double kBorder = 1.0 / 16;
// Cells a side of the hemisphere: in which leaves and elements look for the sky, into which borders
// of openings are divided at points of elements, and at those of the output; there twice as many
// below this accuracy.
constexpr int kLeafCells = 64, kElementCells = 32, kElementFinest = 64, kFinestCells = 128;
constexpr double kFineAccuracy = 0.015;
// What panes leave differs over an element by this share where no border of one crosses it.
constexpr double kPaneBorder = 0.05;
constexpr double kSmallShare = 1e-4;  // of the scene's area: elements that are looked at roughly

double SumOf(const Rgb& c) { return c.x + c.y + c.z; }

Random SeedOf(uint64_t seed, const NodeId& id) {
  return Random(Hash(seed, 0x1164u, Hash(id.surface, id.path)));
}

}  // namespace

// The light of one source as a point sees it.
struct LightField::Arrival {
  Vec3 from{0.0};    // a point of the light, or far away towards it
  double share = 0;  // of the intensity: cosine over squared distance, or cosine
  Rgb intensity{0.0};
  Rgb left{1.0};      // of that, by panes; the intensity is with it
  double facing = 1;  // of a point of a disc: cosine over that of the disc's middle

  Rgb irradiance() const { return share * intensity; }
};

// disc: a point of the unit disk, for a light that is one.
LightField::Arrival LightField::ArrivalAt(const Source& source, const Vec3& point,
                                          const Vec3& normal,
                                          const std::array<double, 2>& disc) const {
  const Light& light = source.light;
  if (light.kind == LightKind::kDirectional) {
    const double cosine = std::max(0.0, -glm::dot(normal, light.direction));
    // An even disc, seen across: even shares of it bring even shares of the irradiance.
    const double sine2 = 1 / (1 + 1 / (light.disc_radius * light.disc_radius));
    const double sine2_here = sine2 * (disc[0] * disc[0] + disc[1] * disc[1]);
    const Vec3 aside =
        std::sqrt(sine2 / (1 - sine2_here)) * (disc[0] * source.side + disc[1] * source.across);
    Rgb intensity = medium_ ? light.intensity * LeftFromOutside(source, point) : light.intensity;
    const Vec3 from = point + far_m_ * (aside - light.direction);
    if (!(cosine > 0)) return {from, 0, intensity};
    const double facing = std::max(0.0, 1 + glm::dot(normal, aside) / cosine);
    if (panes_ == nullptr) return {from, cosine, intensity, Rgb(1.0), facing};
    const Rgb left = LeftByPanes(source, point, from);
    return {from, cosine, intensity * left, left, facing};
  }
  const Vec3 d = light.position_m - point;
  const double distance2 = glm::dot(d, d), distance = std::sqrt(distance2);
  const double height = glm::dot(normal, d);
  if (!(height > 0) || !(distance2 > 0)) return {light.position_m, 0, Rgb(0.0)};
  Rgb intensity = Intensity(source, -d / distance);
  if (medium_) intensity *= medium_->medium.Along(distance);
  Rgb left(1.0);
  if (panes_ != nullptr) left = LeftByPanes(source, point, light.position_m);
  return {light.position_m, height / (distance2 * distance), left * intensity, left};
}

// Of a directional light; by way of mirrors the end of the way is that from the last of them on,
// which leaves the box as the light itself comes in.
Rgb LightField::LeftFromOutside(const Source& source, const Vec3& point) const {
  const Vec3 towards = -source.light.direction;
  if (source.image == nullptr) return medium_->FromOutside(point, towards);
  const Isometry& back = source.image->back;
  return medium_->FromOutside(back.Point(point), back.Direction(towards));
}

Rgb LightField::LeftByPanes(const Source& source, const Vec3& point, const Vec3& from) const {
  return source.image == nullptr ? panes_->Along(point, from)
                                 : panes_->Along(point, from, *source.image);
}

double LightField::AreaShare(const ConvexPolygon& polygon) const {
  return polygon.Area() / hierarchy_.clusters()[0].area_m2;
}

// Points of an element, spread evenly and by chance.
struct LightField::Samples {
  Samples(const ConvexPolygon& polygon, double noise_m, Random random)
      : inside(DrawnIn(polygon, noise_m)), normal(polygon.Normal()) {
    constexpr int kSide = DiscGrid::kFewestCells;
    static_assert(kSide * kSide == kSamples);
    for (int i = 0; i < kSamples; ++i) {
      const double u = (i % kSide + random.Unit()) / kSide;
      const double v = (i / kSide + random.Unit()) / kSide;
      points[i] = SamplePolygon(inside, u, v);
      disc[i] = PointOfDisc(kSide, static_cast<uint32_t>(i), random);
    }
    for (int i = 0; i < 4; ++i) {
      const Vec3& corner = inside.v[i % inside.count];
      rim[2 * i] = corner;
      rim[2 * i + 1] = 0.5 * (corner + inside.v[(i + 1) % inside.count]);
    }
  }

  ConvexPolygon inside;
  Vec3 normal;
  std::array<Vec3, kSamples> points;
  std::array<std::array<double, 2>, kSamples> disc;  // where to look at lights that are discs
  std::array<Vec3, RayScene::kPacket> rim;           // corners and middles of sides
};

LightField::LightField(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                       const Scout& scout, const EffectsPlan& plan, const Medium* medium,
                       const Panes* panes, double accuracy, uint64_t seed)
    : hierarchy_(hierarchy),
      rays_(rays),
      mirrors_(mirrors),
      scout_(scout),
      shadows_(plan.occlusion),
      seed_(seed),
      far_m_(2 * hierarchy.extent_m()),
      panes_(panes),
      finest_(accuracy < kFineAccuracy ? 2 * kFinestCells : kFinestCells),
      sun_cells_(DiscGrid::CellsFor(accuracy)) {
  if (medium != nullptr) medium_ = MediumInBox{*medium, hierarchy.clusters()[0].bounds};
  const auto lit = ClosedComponentsLit(hierarchy, rays, scout, seed);
  for (size_t l = 0; l < lit.size(); ++l) {
    const Light& light = hierarchy.scene().lights[l];
    if (!(light.is_sun() ? plan.sun : plan.lights)) continue;
    AddSource(light, nullptr, lit[l]);
    power_w_ += BroughtPower(hierarchy, light);
    for (const MirrorImage& image : mirrors.images()) AddSource(light, &image, {});
  }
  const Sky& sky = hierarchy.scene().sky;
  if (!plan.sky || !sky.exists()) return;
  sky_.emplace(hierarchy, rays, mirrors, far_m_, shadows_, medium_ ? &*medium_ : nullptr, panes);
  for (size_t i = 0; i < sky.texels.size(); i += 3) {
    brightest_sky_ =
        glm::max(brightest_sky_, Rgb(sky.texels[i], sky.texels[i + 1], sky.texels[i + 2]));
  }
  for (uint32_t s = 0; s < scout.closed.size(); ++s) {
    sees_sky_.push_back(shadows_ && scout.closed[s] != 0 ? 0 : 1);
    escape_.push_back(shadows_ ? scout.escape[s] : 1.0F);
    const double open = escape_.back();
    power_w_ += std::numbers::pi * hierarchy.surface_area_m2(s) * open * sky.MeanRadiance();
  }
}

void LightField::AddSource(const Light& light, const MirrorImage* image,
                           std::vector<uint32_t> lights_up) {
  Source source{light, {}, {}, image, light, std::move(lights_up)};
  if (image != nullptr) {
    source.light.position_m = image->image.Point(light.position_m);
    source.light.direction = image->image.Direction(light.direction);
    source.light.intensity *= image->share;
  }
  const Vec3& d = source.light.direction;
  source.side = glm::normalize(glm::cross(d, std::abs(d.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  source.across = glm::cross(d, source.side);
  (light.is_sun() ? suns_ : lights_).push_back(source);
}

// Towards where a point or spot sends it, or its image seems to.
Rgb LightField::Intensity(const Source& source, const Vec3& direction) const {
  const auto& tables = hierarchy_.scene().photometries;
  if (source.image == nullptr) return IntensityTowards(source.light, tables, direction);
  return source.image->share *
         IntensityTowards(source.original, tables, source.image->back.Direction(direction));
}

GivenIrradiance LightField::Over(const NodeId& id, const ConvexPolygon& polygon) const {
  const Samples samples(polygon, rays_.coordinate_noise_m(), SeedOf(seed_, id));
  GivenIrradiance sum = FromLights(id, polygon, samples);
  if (sky_ && sees_sky_[id.surface] != 0) AddSky(id, samples, &sum);
  return sum;
}

GivenIrradiance LightField::FromLights(const NodeId& id, const ConvexPolygon& polygon,
                                       const Samples& samples) const {
  GivenIrradiance sum;
  for (const Source& light : lights_) AddLight(light, id, polygon, samples, &sum);
  for (const Source& sun : suns_) AddLight(sun, id, polygon, samples, &sum);
  return sum;
}

GivenIrradiance LightField::OverSurface(uint32_t surface) const {
  const NodeId id{surface, 1};
  const ConvexPolygon& polygon = hierarchy_.geometry(surface);
  GivenIrradiance sum =
      FromLights(id, polygon, Samples(polygon, rays_.coordinate_noise_m(), SeedOf(seed_, id)));
  if (sky_) {
    sum.mean += std::numbers::pi * escape_[surface] * hierarchy_.scene().sky.MeanRadiance();
  }
  return sum;
}

double LightField::MostPower(const NodeId& id, const ConvexPolygon& polygon) const {
  const Vec3 normal = polygon.Normal();
  double most = 0;  // W/m²
  for (const auto* sources : {&lights_, &suns_}) {
    for (const Source& source : *sources) {
      const Light& light = source.light;
      if (IsShutOut(source, id.surface)) continue;
      if (light.kind == LightKind::kDirectional) {
        most += std::max(0.0, -glm::dot(normal, light.direction)) * SumOf(light.intensity);
        continue;
      }
      const double height = glm::dot(normal, light.position_m - polygon.v[0]);
      if (height <= 0) continue;
      const Vec3 foot = light.position_m - height * normal;
      const Vec3 d = light.position_m - NearestInside(polygon, normal, foot);
      most += SumOf(LargestIntensity(light, hierarchy_.scene().photometries)) /
              std::max(glm::dot(d, d), 1e-300);
    }
  }
  if (sky_ && sees_sky_[id.surface] != 0) most += std::numbers::pi * SumOf(brightest_sky_);
  return most * polygon.Area();
}

// Least and most of what one light brings to points of an element without obstacles: over the
// samples, the corners, the point closest to the light and the one its axis meets.
double LightField::UnoccludedRange(const Source& source, const ConvexPolygon& inside,
                                   const Vec3& normal, double least, double most) const {
  const Light& light = source.light;
  if (light.kind == LightKind::kDirectional) {
    return medium_ || panes_ != nullptr ? most - least : 0;
  }
  const auto probe = [&](const Vec3& point) {
    const double value = SumOf(ArrivalAt(source, point, normal, {}).irradiance());
    least = std::min(least, value);
    most = std::max(most, value);
  };
  for (int i = 0; i < inside.count; ++i) probe(inside.v[i]);
  const double height = glm::dot(normal, light.position_m - inside.v[0]);
  probe(NearestInside(inside, normal, light.position_m - height * normal));
  const double falls = -glm::dot(normal, light.direction);
  const bool has_axis = light.kind == LightKind::kSpot || light.kind == LightKind::kPhotometric;
  if (has_axis && falls > 1e-9) {
    probe(NearestInside(inside, normal, light.position_m + height / falls * light.direction));
  }
  return most - least;
}

// What a light sends to eight points, and which of them it reaches.
struct LightField::Look {
  std::array<Arrival, RayScene::kPacket> arrivals;
  uint32_t lit = 0, free = 0;  // by bits: facing the light; and with nothing between

  int reached() const { return std::popcount(free); }
  int hidden() const { return std::popcount(lit & ~free); }
};

// The points are looked at from other points of a disc, from the one of sample `first` on.
LightField::Look LightField::LookAt(const Source& source, const Samples& samples, uint32_t polygon,
                                    std::span<const Vec3> points, size_t first) const {
  Look look;
  RayPacket packet;
  for (int i = 0; i < RayScene::kPacket; ++i) {
    look.arrivals[i] = ArrivalAt(source, points[i], samples.normal, samples.disc[first + i]);
    if (SumOf(look.arrivals[i].irradiance()) > 0) {
      packet.Set(i, {points[i], look.arrivals[i].from, polygon, RayHit::kNothing});
    }
  }
  look.lit = packet.valid;
  look.free = Reaches(source, packet);
  return look;
}

// What panes leave of light that arrives, over points.
struct LightField::LeftRange {
  Rgb least{1.0}, most{0.0};

  void Add(const Look& look) {
    for (int i = 0; i < RayScene::kPacket; ++i) {
      if ((look.free >> i & 1) == 0) continue;
      least = glm::min(least, look.arrivals[i].left);
      most = glm::max(most, look.arrivals[i].left);
    }
  }
  double Range() const { return std::max({most.x - least.x, most.y - least.y, most.z - least.z}); }
};

void LightField::AddLight(const Source& source, const NodeId& id, const ConvexPolygon& polygon,
                          const Samples& samples, GivenIrradiance* sum) const {
  if (IsShutOut(source, id.surface)) return;
  const Light& light = source.light;
  const bool distant = light.kind == LightKind::kDirectional;
  const double cosine = -glm::dot(samples.normal, light.direction);
  if (distant ? cosine <= 0 : glm::dot(samples.normal, light.position_m - polygon.v[0]) <= 0) {
    return;
  }
  const uint32_t own = hierarchy_.surfaces()[id.surface].polygon;
  Rgb whole(0.0), seen(0.0);  // over the samples: without obstacles, past them
  double shares = 0, least = std::numeric_limits<double>::infinity(), most = 0;
  int reached = 0, hidden = 0;
  LeftRange left;
  uint64_t& rays = light.is_sun() ? sum->rays.sun : sum->rays.lights;
  for (int first = 0; first < kSamples; first += RayScene::kPacket) {
    const Look look = LookAt(source, samples, own,
                             std::span(samples.points).subspan(first, RayScene::kPacket), first);
    for (int i = 0; i < RayScene::kPacket; ++i) {
      const Rgb irradiance = look.arrivals[i].irradiance();
      const double facing = look.arrivals[i].facing;
      shares += facing * look.arrivals[i].share;
      whole += facing * irradiance;
      if ((look.free >> i & 1) != 0) seen += facing * irradiance;
      least = std::min(least, SumOf(irradiance));
      most = std::max(most, SumOf(irradiance));
    }
    left.Add(look);
    reached += look.reached();
    hidden += look.hidden();
    if (MayBeHidden(source)) rays += static_cast<uint64_t>(std::popcount(look.lit));
  }
  if (MayBeHidden(source) || panes_ != nullptr) {  // borders of shadows cross the rim
    const Look rim = LookAt(source, samples, own, samples.rim, 0);
    reached += rim.reached();
    hidden += rim.hidden();
    if (MayBeHidden(source)) rays += static_cast<uint64_t>(std::popcount(rim.lit));
    left.Add(rim);
  }
  // Mean share without obstacles over that of the samples: makes even intensities exact.
  const double exact = distant ? cosine : SolidAngle(polygon, light.position_m) / polygon.Area();
  const double scale = shares > 0 ? exact / shares : 0.0;
  sum->mean += scale * seen;
  const double unoccluded = scale * SumOf(whole);
  const double range = UnoccludedRange(source, samples.inside, samples.normal, least, most);
  // A border of a pane crosses the element as that of a shadow does.
  if (const double step = left.Range(); step > kPaneBorder) {
    sum->range += step * std::max(most, unoccluded);
    sum->border += step * kBorder * std::max(most, unoccluded);
  }
  AddDoubt({unoccluded, SumOf(whole) > 0 ? SumOf(seen) / SumOf(whole) : 0.0, range,
            std::max(most, unoccluded), reached > 0, hidden > 0,
            medium_ || panes_ != nullptr || light.kind == LightKind::kSpot ||
                light.kind == LightKind::kPhotometric,
            MayBeHidden(source)},
           sum);
}

// How far what one light brings to an element varies, and may be wrong.
void LightField::AddDoubt(const Doubt& doubt, GivenIrradiance* sum) const {
  const bool partly = doubt.reaches && doubt.is_hidden;
  if (partly) {
    sum->range += doubt.most;
    sum->border += kBorder * doubt.most;
  } else {
    sum->range += doubt.range * (doubt.reaches ? 1.0 : kUnseen);
    if (doubt.may_be_hidden) sum->range += kUnseen * doubt.unoccluded;
  }
  const double visibility = partly ? std::sqrt(doubt.share * (1 - doubt.share)) : 0.0;
  const double deviation = doubt.may_be_hidden ? std::max(visibility, kUnseen) : 0.0;
  // Intensities that vary are summed over the samples: their deviation is about 0.3 of the range.
  const double uneven = doubt.uneven ? 0.3 * doubt.range : 0.0;
  sum->error += (deviation * doubt.unoccluded + uneven) / std::sqrt(kSamples);
}

// Of a few points of the element, each looked at in steps from a coarse grid; of small elements, of
// which there are many in scenes of many polygons, a single point and a coarser grid.
void LightField::AddSky(const NodeId& id, const Samples& samples, GivenIrradiance* sum) const {
  const bool small = AreaShare(samples.inside) < kSmallShare;
  const int points = small ? 1 : 4;
  LitPoint point;
  point.normal = samples.normal;
  point.polygon = hierarchy_.surfaces()[id.surface].polygon;
  point.seed = Hash(seed_, 0x0bedu, Hash(id.surface, id.path));
  const SkyOpenings openings =
      sky_->OpeningsOf(samples.inside, point, small ? kElementCells / 2 : kElementCells);
  sum->rays.sky += openings.rays;
  Rgb mean(0.0);
  double least = std::numeric_limits<double>::infinity(), most = 0, deviation = 0;
  for (int k = 0; k < points; ++k) {
    // One of each quarter.
    constexpr std::array<int, 4> kChosen = {0, 7, 9, 14};
    point.position = samples.points[kChosen[k]];
    point.seed = Hash(seed_, Hash(id.surface, id.path), static_cast<uint64_t>(k));
    const SkyField::Seen seen = sky_->At(point, openings, kElementFinest);
    mean += seen.irradiance / static_cast<double>(points);
    least = std::min(least, SumOf(seen.irradiance));
    most = std::max(most, SumOf(seen.irradiance));
    deviation += seen.deviation / points;
    sum->rays.sky += seen.rays;
  }
  sum->mean += mean;
  // Two numbers of four with this deviation are 2.06 of it apart by chance alone.
  const double range = std::max(0.0, most - least - 2.06 * deviation);
  sum->range += range;
  sum->error += (0.3 * range + deviation) / std::sqrt(points);
  // Output points look more closely: errors fall as cells to the power of 3/2.
  const double finer = finest_ > kFinestCells ? 0.125 : 0.354;
  sum->border += 0.8 * finer * deviation;
}

// Sixteen points of the disc, and more where these disagree.
Rgb LightField::FromSun(const Source& sun, const LitPoint& point, LightRays* rays) const {
  const Arrival middle = ArrivalAt(sun, point.position, point.normal, {});
  if (!(middle.share > 0)) return Rgb(0.0);
  if (!MayBeHidden(sun) && panes_ == nullptr) return middle.irradiance();
  DiscGrid grid(sun_cells_, Random(Hash(point.seed, 0x50au)));
  do {
    const std::span<const uint32_t> cells = grid.unknown();
    for (size_t first = 0; first < cells.size(); first += RayScene::kPacket) {
      const auto some =
          cells.subspan(first, std::min<size_t>(RayScene::kPacket, cells.size() - first));
      LookAtDisc(sun, point, some, &grid);
      if (MayBeHidden(sun)) rays->sun += some.size();
    }
  } while (grid.Divide());
  const double radius = sun.light.disc_radius, sine = radius / std::sqrt(1 + radius * radius);
  const Vec3 slope = sine / middle.share * point.normal;
  return grid.Mean({glm::dot(slope, sun.side), glm::dot(slope, sun.across)}, sine);
}

// Into cells of a sun's disc, no more than a packet.
void LightField::LookAtDisc(const Source& sun, const LitPoint& point,
                            std::span<const uint32_t> cells, DiscGrid* grid) const {
  std::array<Arrival, RayScene::kPacket> arrivals;
  RayPacket packet;
  for (size_t i = 0; i < cells.size(); ++i) {
    arrivals[i] = ArrivalAt(sun, point.position, point.normal, grid->PointIn(cells[i]));
    packet.Set(static_cast<int>(i),
               {point.position, arrivals[i].from, point.polygon, RayHit::kNothing});
  }
  const uint32_t free = Reaches(sun, packet);
  for (size_t i = 0; i < cells.size(); ++i) {
    grid->Set(cells[i], (free >> i & 1) != 0 ? arrivals[i].irradiance() : Rgb(0.0));
  }
}

SkyOpenings LightField::OpeningsOf(const NodeId& id, const ConvexPolygon& polygon) const {
  if (!sky_ || sees_sky_[id.surface] == 0) return {};
  LitPoint point;
  point.normal = polygon.Normal();
  point.polygon = hierarchy_.surfaces()[id.surface].polygon;
  point.seed = Hash(seed_, 0x0be0u, Hash(id.surface, id.path));
  return sky_->OpeningsOf(DrawnIn(polygon, rays_.coordinate_noise_m()), point,
                          AreaShare(polygon) < kSmallShare ? kLeafCells / 2 : kLeafCells);
}

Rgb LightField::At(const LitPoint& point, const SkyOpenings& openings, LightRays* rays) const {
  Rgb irradiance(0.0);
  for (size_t first = 0; first < lights_.size(); first += RayScene::kPacket) {
    const size_t count = std::min<size_t>(RayScene::kPacket, lights_.size() - first);
    std::array<Arrival, RayScene::kPacket> arrivals;
    RayPacket packet;
    for (size_t i = 0; i < count; ++i) {
      arrivals[i] = ArrivalAt(lights_[first + i], point.position, point.normal, {});
      if (SumOf(arrivals[i].irradiance()) > 0) {
        packet.Set(static_cast<int>(i),
                   {point.position, arrivals[i].from, point.polygon, RayHit::kNothing});
      }
    }
    if (packet.valid == 0) continue;
    const uint32_t free = FreeOf(first, packet);
    if (shadows_) rays->lights += static_cast<uint64_t>(std::popcount(packet.valid));
    for (size_t i = 0; i < count; ++i) {
      if ((free >> i & 1) != 0) irradiance += arrivals[i].irradiance();
    }
  }
  for (const Source& sun : suns_) irradiance += FromSun(sun, point, rays);
  if (openings.cells > 0) {
    const SkyField::Seen seen = sky_->At(point, openings, finest_);
    irradiance += seen.irradiance;
    rays->sky += seen.rays;
  }
  return irradiance;
}

}  // namespace isolux
