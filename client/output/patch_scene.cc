#include "client/output/patch_scene.h"

#include <embree3/rtcore.h>

#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "client/output/interpolate.h"

namespace isolux {
namespace {

// Embree reports errors of building and of memory through its callback only.
struct ErrorSink {
  std::mutex mutex;
  std::string message;  // the first
};

void OnError(void* user, RTCError, const char* text) {
  auto* sink = static_cast<ErrorSink*>(user);
  const std::lock_guard lock(sink->mutex);
  if (sink->message.empty()) sink->message = text != nullptr ? text : "unknown error";
}

struct Context {
  RTCIntersectContext base;
  bool both_sides = false;
};

// Turns hits from behind away.
void CullBackFaces(const RTCFilterFunctionNArguments* args) {
  if (args->context == nullptr || reinterpret_cast<const Context*>(args->context)->both_sides) {
    return;
  }
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const float facing =
        RTCRayN_dir_x(args->ray, args->N, i) * RTCHitN_Ng_x(args->hit, args->N, i) +
        RTCRayN_dir_y(args->ray, args->N, i) * RTCHitN_Ng_y(args->hit, args->N, i) +
        RTCRayN_dir_z(args->ray, args->N, i) * RTCHitN_Ng_z(args->hit, args->N, i);
    if (facing >= 0) args->valid[i] = 0;
  }
}

}  // namespace

struct PatchScene::Impl {
  const PatchFile* file = nullptr;
  Bounds3 bounds;
  Vec3 centre{0.0};  // floats are relative to it
  ErrorSink errors;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<std::array<uint32_t, 3>> triangles;  // vertices of the file
  std::vector<uint32_t> face_of;                   // of each triangle

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  Status Failure(const char* what) {
    const std::lock_guard lock(errors.mutex);
    return {
        StatusCode::kInternal,
        fmt::format("{}: {}", what, errors.message.empty() ? "no reason given" : errors.message)};
  }

  void CutFaces();
  Status Commit();
};

void PatchScene::Impl::CutFaces() {
  std::vector<Vec3> corners;
  for (uint32_t f = 0; f < file->faces.size(); ++f) {
    const std::vector<uint32_t>& vertices = file->faces[f].vertices;
    corners.clear();
    for (const uint32_t v : vertices) corners.push_back(file->vertices[v].position);
    for (const auto& t : Triangulate(corners)) {
      triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
      face_of.push_back(f);
    }
  }
}

Status PatchScene::Impl::Commit() {
  device = rtcNewDevice("isa=avx2");
  if (device == nullptr) {
    return MakeStatus(StatusCode::kInternal, "Embree does not start (error {}): AVX2 is needed",
                      static_cast<int>(rtcGetDeviceError(nullptr)));
  }
  rtcSetDeviceErrorFunction(device, OnError, &errors);
  scene = rtcNewScene(device);
  if (scene == nullptr) return Failure("Embree makes no scene");
  // Robust: no ray slips between two triangles that share a side.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                             RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                             file->vertices.size()));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), triangles.size()));
  if (points == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    return Failure("Embree has no memory for the faces");
  }
  for (size_t v = 0; v < file->vertices.size(); ++v) {
    for (int d = 0; d < 3; ++d) {
      points[3 * v + d] = static_cast<float>(file->vertices[v].position[d] - centre[d]);
    }
  }
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) indices[3 * t + k] = triangles[t][k];
  }
  rtcSetGeometryIntersectFilterFunction(geometry, CullBackFaces);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  const std::lock_guard lock(errors.mutex);
  if (errors.message.empty()) return {};
  return MakeStatus(StatusCode::kInternal, "Embree cannot build the scene: {}", errors.message);
}

PatchScene::PatchScene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PatchScene::PatchScene(PatchScene&&) noexcept = default;
PatchScene& PatchScene::operator=(PatchScene&&) noexcept = default;
PatchScene::~PatchScene() = default;

Result<PatchScene> PatchScene::Build(const PatchFile& file) {
  auto impl = std::make_unique<Impl>();
  impl->file = &file;
  for (const PatchVertex& v : file.vertices) impl->bounds.Add(v.position);
  if (file.faces.empty() || impl->bounds.Empty()) {
    return Error(StatusCode::kInvalidArgument, "the patch file has no faces: nothing to see");
  }
  impl->centre = impl->bounds.Centre();
  impl->CutFaces();
  RETURN_IF_ERROR(impl->Commit());
  return PatchScene(std::move(impl));
}

const PatchFile& PatchScene::file() const { return *impl_->file; }
const Bounds3& PatchScene::bounds() const { return impl_->bounds; }

std::optional<PatchHit> PatchScene::Cast(const Vec3& origin, const Vec3& direction,
                                         bool both_sides) const {
  Context context;
  rtcInitIntersectContext(&context.base);
  context.both_sides = both_sides;
  RTCRayHit ray{};
  const Vec3 start = origin - impl_->centre;
  ray.ray.org_x = static_cast<float>(start.x);
  ray.ray.org_y = static_cast<float>(start.y);
  ray.ray.org_z = static_cast<float>(start.z);
  ray.ray.dir_x = static_cast<float>(direction.x);
  ray.ray.dir_y = static_cast<float>(direction.y);
  ray.ray.dir_z = static_cast<float>(direction.z);
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = 0xffffffffu;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context.base, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  // The place from the triangle in double, not from the distance in float.
  PatchHit hit;
  hit.face = impl_->face_of[ray.hit.primID];
  const std::array<uint32_t, 3>& t = impl_->triangles[ray.hit.primID];
  const double u = ray.hit.u, v = ray.hit.v;
  hit.position = (1 - u - v) * impl_->file->vertices[t[0]].position +
                 u * impl_->file->vertices[t[1]].position +
                 v * impl_->file->vertices[t[2]].position;
  hit.distance = ray.ray.tfar;
  return hit;
}

}  // namespace isolux
