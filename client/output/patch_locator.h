// Where on a patch file a point lies, and the irradiance there, interpolated over the face.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/patch_file.h"
#include "common/vec.h"

namespace isolux {

// One side of one file polygon, as a number: surfaces of two solutions of one scene are matched by
// it.
inline uint64_t SideKey(const PatchFace& face) { return uint64_t{face.polygon} << 1 | face.side; }

std::vector<Vec3> CornersOf(const PatchFile& file, const PatchFace& face);

// The normal of a polygon, as long as its area.
Vec3 AreaVector(std::span<const Vec3> corners);

// W/m², from the face's vertices by mean value coordinates.
Rgb IrradianceAt(const PatchFile& file, uint32_t face, const Vec3& point);
// The same in each spectral band.
std::vector<double> BandIrradianceAt(const PatchFile& file, uint32_t face, const Vec3& point);

class PatchLocator {
 public:
  // `file` must outlive the locator.
  explicit PatchLocator(const PatchFile& file);
  PatchLocator(PatchLocator&&) noexcept;
  PatchLocator& operator=(PatchLocator&&) noexcept;
  ~PatchLocator();

  bool Has(uint64_t side_key) const;
  // The face of this side that contains the point, or comes within rounding of it.
  std::optional<uint32_t> Find(uint64_t side_key, const Vec3& point) const;
  // The face of any side that looks along the (unit) normal and contains the point: the one whose
  // plane is nearest.
  std::optional<uint32_t> FindAlong(const Vec3& normal, const Vec3& point) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isolux
