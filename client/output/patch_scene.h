// The faces of a patch file as rays see them. A face is seen from its lit side only: a ray passes
// through it from behind, so that a camera outside a room whose walls have no outer side looks in.
// Coincident front and back faces are told apart the same way. Cast may be called from any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/scene/patch_file.h"
#include "common/util/parallel.h"

namespace isolux {

struct PatchHit {
  uint32_t face = 0;
  Vec3 position{0.0};  // in the file's unit and origin
  double distance = 0;
};

class PatchScene {
 public:
  // `file` must outlive the scene. Fails where Embree cannot be used or runs out of memory.
  static Result<PatchScene> Build(const PatchFile& file);
  PatchScene(PatchScene&&) noexcept;
  PatchScene& operator=(PatchScene&&) noexcept;
  ~PatchScene();

  const PatchFile& file() const;
  const Bounds3& bounds() const;

  // The nearest face met from its lit side; with `both_sides` the nearest of all (of twins either).
  std::optional<PatchHit> Cast(const Vec3& origin, const Vec3& direction,
                               bool both_sides = false) const;

 private:
  struct Impl;
  explicit PatchScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
