#include "worker/radiosity/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/util/check.h"

namespace isolux {
namespace {

// What a filter knows of the packet it is called for. The base comes first: Embree hands it back.
struct PacketContext {
  RTCIntersectContext base;
  const uint32_t* polygon_of;  // of a primitive
  const Hierarchy* hierarchy;
  const uint32_t* from_polygon;  // of each ray
  const uint32_t* to_polygon;
};

// Whether a ray meets a side that lies against another polygon: that one is what it meets.
bool MeetsCovered(const RTCFilterFunctionNArguments* arguments, unsigned i, const Scene& scene,
                  uint32_t polygon) {
  const uint8_t sides = scene.polygons[polygon].sides & (kFrontCovered | kBackCovered);
  if (sides == 0) return false;
  const Vec3 direction(RTCRayN_dir_x(arguments->ray, arguments->N, i),
                       RTCRayN_dir_y(arguments->ray, arguments->N, i),
                       RTCRayN_dir_z(arguments->ray, arguments->N, i));
  const Vec3 normal = SideGeometry(scene, polygon, Side::kFront).AreaVector();
  return (sides & (glm::dot(normal, direction) < 0 ? kFrontCovered : kBackCovered)) != 0;
}

void RejectOwnHits(const RTCFilterFunctionNArguments* arguments) {
  const auto* context = reinterpret_cast<const PacketContext*>(arguments->context);
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    const unsigned ray = RTCRayN_id(arguments->ray, arguments->N, i);
    const uint32_t hit = context->polygon_of[RTCHitN_primID(arguments->hit, arguments->N, i)];
    const uint32_t plane = context->hierarchy->plane_of(hit);
    const uint32_t from = context->from_polygon[ray];
    const uint32_t to = context->to_polygon[ray];
    const bool own =
        hit == from || plane == context->hierarchy->plane_of(from) ||
        (to != RayHit::kNothing && (hit == to || plane == context->hierarchy->plane_of(to)));
    if (own || MeetsCovered(arguments, i, context->hierarchy->scene(), hit)) {
      arguments->valid[i] = 0;
    }
  }
}

void OnError(void*, RTCError code, const char* message) {
  // Embree reports errors here alone; none of ours is recoverable.
  std::fprintf(stderr, "embree: error %d: %s\n", static_cast<int>(code), message);
  CHECK(code == RTC_ERROR_NONE);
}

}  // namespace

struct RayScene::Impl {
  const Hierarchy* hierarchy = nullptr;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<uint32_t> polygon_of;  // of each triangle
  float coordinate_noise_m = 0;      // 64 float roundings of the largest coordinate

  PacketContext Context() const {
    PacketContext context;
    rtcInitIntersectContext(&context.base);
    context.polygon_of = polygon_of.data();
    context.hierarchy = hierarchy;
    return context;
  }

  void SetRay(RTCRay8& ray, int i, const Vec3& from, const Vec3& direction) const {
    const double length = glm::length(direction);
    // Hits so near an end do not count: not looked for, they need not be rejected.
    const float near_share =
        length > 0 ? std::min(0.25F, coordinate_noise_m / static_cast<float>(length)) : 0.25F;
    ray.org_x[i] = static_cast<float>(from.x);
    ray.org_y[i] = static_cast<float>(from.y);
    ray.org_z[i] = static_cast<float>(from.z);
    ray.dir_x[i] = static_cast<float>(direction.x);
    ray.dir_y[i] = static_cast<float>(direction.y);
    ray.dir_z[i] = static_cast<float>(direction.z);
    ray.tnear[i] = near_share;
    ray.tfar[i] = std::numeric_limits<float>::infinity();
    ray.time[i] = 0;
    ray.mask[i] = ~0U;
    ray.id[i] = static_cast<unsigned>(i);
    ray.flags[i] = 0;
  }
};

RayScene::RayScene(const Hierarchy& hierarchy) : impl_(std::make_unique<Impl>()) {
  const Scene& scene = hierarchy.scene();
  impl_->hierarchy = &hierarchy;
  // One instruction set whatever the processor offers, so that hits are the same everywhere; the
  // build runs on this thread alone.
  impl_->device = rtcNewDevice("isa=avx2,threads=1,frequency_level=simd256");
  CHECK(impl_->device != nullptr);
  rtcSetDeviceErrorFunction(impl_->device, OnError, nullptr);
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);

  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), std::max<size_t>(1, scene.vertices.size())));
  float largest = 0;
  for (size_t i = 0; i < scene.vertices.size(); ++i) {
    for (int d = 0; d < 3; ++d) {
      vertices[3 * i + d] = static_cast<float>(scene.vertices[i][d]);
      largest = std::max(largest, std::abs(vertices[3 * i + d]));
    }
  }
  impl_->coordinate_noise_m = 64 * 6e-8F * largest;
  size_t triangles = 0;
  for (const Polygon& polygon : scene.polygons) triangles += polygon.vertex_count() - 2;
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), std::max<size_t>(1, triangles)));
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    for (int i = 1; i + 1 < polygon.vertex_count(); ++i) {
      unsigned* triangle = indices + 3 * impl_->polygon_of.size();
      triangle[0] = polygon.vertices[0];
      triangle[1] = polygon.vertices[i];
      triangle[2] = polygon.vertices[i + 1];
      impl_->polygon_of.push_back(p);
    }
  }
  rtcSetGeometryOccludedFilterFunction(geometry, RejectOwnHits);
  rtcSetGeometryIntersectFilterFunction(geometry, RejectOwnHits);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene);
}

double RayScene::coordinate_noise_m() const { return impl_->coordinate_noise_m; }

RayScene::~RayScene() {
  rtcReleaseScene(impl_->scene);
  rtcReleaseDevice(impl_->device);
}

void RayPacket::Set(int i, const Segment& segment) {
  for (int c = 0; c < 3; ++c) {
    from[c][i] = static_cast<float>(segment.from[c]);
    to[c][i] = static_cast<float>(segment.to[c]);
  }
  from_polygon[i] = segment.from_polygon;
  to_polygon[i] = segment.to_polygon;
  valid |= 1U << i;
}

uint32_t RayScene::Visible(const RayPacket& packet) const {
  alignas(32) RTCRay8 rays;
  const auto store = [](float* to, FloatLanes v) {
    _mm256_store_ps(to, reinterpret_cast<__m256>(v));
  };
  const FloatLanes x = packet.to[0] - packet.from[0];
  const FloatLanes y = packet.to[1] - packet.from[1];
  const FloatLanes z = packet.to[2] - packet.from[2];
  // Hits so near an end do not count: not looked for, they need not be rejected.
  const FloatLanes near_share =
      Minimum(impl_->coordinate_noise_m / SquareRoot(x * x + y * y + z * z), SplatFloat(0.25F));
  store(rays.org_x, packet.from[0]);
  store(rays.org_y, packet.from[1]);
  store(rays.org_z, packet.from[2]);
  store(rays.dir_x, x);
  store(rays.dir_y, y);
  store(rays.dir_z, z);
  store(rays.tnear, near_share);
  store(rays.tfar, 1 - near_share);
  store(rays.time, FloatLanes{});
  alignas(32) int valid[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    valid[i] = (packet.valid >> i & 1) != 0 ? -1 : 0;
    rays.mask[i] = ~0U;
    rays.id[i] = static_cast<unsigned>(i);
    rays.flags[i] = 0;
  }
  PacketContext context = impl_->Context();
  context.from_polygon = packet.from_polygon.data();
  context.to_polygon = packet.to_polygon.data();
  rtcOccluded8(valid, impl_->scene, &context.base, &rays);
  uint32_t visible = 0;
  for (int i = 0; i < kPacket; ++i) {
    if (valid[i] != 0 && rays.tfar[i] >= 0) visible |= 1U << i;
  }
  return visible;
}

bool RayScene::Visible(const Segment& segment) const {
  RayPacket packet;
  packet.Set(0, segment);
  return Visible(packet) != 0;
}

std::array<RayHit, RayScene::kPacket> RayScene::Trace(const std::array<Escape, kPacket>& escapes,
                                                      int count) const {
  alignas(32) int valid[kPacket];
  alignas(32) RTCRayHit8 rays;
  std::array<uint32_t, kPacket> from{}, to;
  to.fill(RayHit::kNothing);
  PacketContext context = impl_->Context();
  context.from_polygon = from.data();
  context.to_polygon = to.data();
  for (int i = 0; i < kPacket; ++i) {
    valid[i] = i < count ? -1 : 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    if (i >= count) continue;
    from[i] = escapes[i].from_polygon;
    impl_->SetRay(rays.ray, i, escapes[i].from, escapes[i].direction);
  }
  rtcIntersect8(valid, impl_->scene, &context.base, &rays);
  std::array<RayHit, kPacket> hits;
  for (int i = 0; i < count; ++i) {
    if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    hits[i].polygon = impl_->polygon_of[rays.hit.primID[i]];
    hits[i].distance = rays.ray.tfar[i];
    const Vec3 normal =
        SideGeometry(impl_->hierarchy->scene(), hits[i].polygon, Side::kFront).AreaVector();
    hits[i].side = glm::dot(normal, escapes[i].direction) < 0 ? Side::kFront : Side::kBack;
  }
  return hits;
}

}  // namespace isolux
