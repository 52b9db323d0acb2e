#include "client/output/patch_locator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "client/output/interpolate.h"

namespace isolux {
namespace {

constexpr double kNearby = 1e-4;  // of a surface's extent: what rounding puts beside a face
constexpr double kAlong = 0.999;  // cosine between a normal asked for and that of a surface
constexpr int kMostCellsASide = 2048;

// A face and how far outside of it a point is: off its plane and beyond its sides, 0 inside.
struct Found {
  uint32_t face = 0;
  double outside = INFINITY;
};

// The faces of one side of one file polygon on a grid in their plane.
class SurfaceGrid {
 public:
  SurfaceGrid(const PatchFile& file, std::vector<uint32_t> faces)
      : file_(&file), faces_(std::move(faces)) {
    Vec3 normal(0.0);
    for (const uint32_t f : faces_) normal += AreaVector(CornersOf(file, file.faces[f]));
    const double length = glm::length(normal);
    normal_ = length > 0 ? normal / length : Vec3(0, 0, 1);
    const Vec3 helper = std::abs(normal_.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    axes_[0] = glm::normalize(glm::cross(normal_, helper));
    axes_[1] = glm::cross(normal_, axes_[0]);
    Fill();
  }

  const Vec3& normal() const { return normal_; }

  // Whether the point may lie on a face of it.
  bool Near(const Vec3& point) const {
    for (int d = 0; d < 3; ++d) {
      const double margin = kNearby * extent_;
      if (point[d] < bounds_.low[d] - margin || point[d] > bounds_.high[d] + margin) return false;
    }
    return true;
  }

  std::optional<Found> Find(const Vec3& point) const {
    const std::array<int, 2> cell{Cell(0, glm::dot(point, axes_[0])),
                                  Cell(1, glm::dot(point, axes_[1]))};
    Found best;
    best.outside = kNearby * extent_;
    bool found = false;
    const size_t c =
        static_cast<size_t>(cell[1]) * static_cast<size_t>(size_) + static_cast<size_t>(cell[0]);
    for (uint32_t i = first_[c]; i < first_[c + 1]; ++i) {
      const double outside = Outside(faces_[entries_[i]], point);
      if (outside >= best.outside) continue;
      best = {faces_[entries_[i]], outside};
      found = true;
    }
    return found ? std::optional(best) : std::nullopt;
  }

 private:
  struct Box {
    std::array<double, 2> low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
  };

  void Fill() {
    std::vector<Box> boxes(faces_.size());
    std::array<double, 2> high{-INFINITY, -INFINITY};
    low_ = {INFINITY, INFINITY};
    for (size_t i = 0; i < faces_.size(); ++i) {
      for (const uint32_t v : file_->faces[faces_[i]].vertices) {
        const Vec3& position = file_->vertices[v].position;
        bounds_.Add(position);
        for (int d = 0; d < 2; ++d) {
          const double x = glm::dot(position, axes_[d]);
          boxes[i].low[d] = std::min(boxes[i].low[d], x);
          boxes[i].high[d] = std::max(boxes[i].high[d], x);
        }
      }
      for (int d = 0; d < 2; ++d) {
        low_[d] = std::min(low_[d], boxes[i].low[d]);
        high[d] = std::max(high[d], boxes[i].high[d]);
      }
    }
    extent_ = std::max({high[0] - low_[0], high[1] - low_[1], 1e-300});
    size_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(faces_.size()))), 1,
                       kMostCellsASide);
    for (int d = 0; d < 2; ++d) scale_[d] = size_ / std::max(high[d] - low_[d], 1e-9 * extent_);

    // Twice over the boxes: count, then place.
    const auto for_cells = [&](const auto& body) {
      for (uint32_t i = 0; i < boxes.size(); ++i) {
        const double margin = kNearby * extent_;
        for (int y = Cell(1, boxes[i].low[1] - margin); y <= Cell(1, boxes[i].high[1] + margin);
             ++y) {
          for (int x = Cell(0, boxes[i].low[0] - margin); x <= Cell(0, boxes[i].high[0] + margin);
               ++x) {
            body(static_cast<size_t>(y) * static_cast<size_t>(size_) + static_cast<size_t>(x), i);
          }
        }
      }
    };
    first_.assign(static_cast<size_t>(size_) * static_cast<size_t>(size_) + 1, 0);
    for_cells([&](size_t cell, uint32_t) { ++first_[cell + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(first_.back());
    std::vector<uint32_t> fill(first_.begin(), first_.end() - 1);
    for_cells([&](size_t cell, uint32_t i) { entries_[fill[cell]++] = i; });
  }

  int Cell(int d, double x) const {
    return static_cast<int>(std::clamp(std::floor((x - low_[d]) * scale_[d]), 0.0, size_ - 1.0));
  }

  double Outside(uint32_t face, const Vec3& point) const {
    const std::vector<Vec3> corners = CornersOf(*file_, file_->faces[face]);
    const Vec3 area = AreaVector(corners);
    const double length = glm::length(area);
    if (!(length > 0)) return INFINITY;
    const Vec3 normal = area / length;
    double beyond = 0;
    for (size_t k = 0; k < corners.size(); ++k) {
      const Vec3 side = corners[(k + 1) % corners.size()] - corners[k];
      const double side_length = glm::length(side);
      if (!(side_length > 0)) continue;
      beyond =
          std::max(beyond, -glm::dot(glm::cross(normal, side), point - corners[k]) / side_length);
    }
    return beyond + std::abs(glm::dot(normal, point - corners[0]));
  }

  const PatchFile* file_;
  std::vector<uint32_t> faces_;
  Vec3 normal_{0.0};
  Bounds3 bounds_;
  std::array<Vec3, 2> axes_{};
  std::array<double, 2> low_{}, scale_{};
  double extent_ = 0;
  int size_ = 1;
  std::vector<uint32_t> first_, entries_;  // of each cell: places in faces_
};

}  // namespace

std::vector<Vec3> CornersOf(const PatchFile& file, const PatchFace& face) {
  std::vector<Vec3> corners;
  corners.reserve(face.vertices.size());
  for (const uint32_t v : face.vertices) corners.push_back(file.vertices[v].position);
  return corners;
}

Vec3 AreaVector(std::span<const Vec3> corners) {
  Vec3 sum(0.0);
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  return 0.5 * sum;
}

namespace {

std::vector<double> WeightsAt(const PatchFile& file, uint32_t face, const Vec3& point) {
  std::vector<double> weights(file.faces[face].vertices.size());
  MeanValueWeights(CornersOf(file, file.faces[face]), point, weights);
  return weights;
}

}  // namespace

std::vector<double> BandIrradianceAt(const PatchFile& file, uint32_t face, const Vec3& point) {
  const std::vector<uint32_t>& vertices = file.faces[face].vertices;
  const std::vector<double> weights = WeightsAt(file, face, point);
  std::vector<double> sums(file.bands.size(), 0.0);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const std::span<const float> h = file.vertex_bands.Irradiance(vertices[k], sums.size());
    for (size_t b = 0; b < sums.size(); ++b) sums[b] += weights[k] * h[b];
  }
  return sums;
}

Rgb IrradianceAt(const PatchFile& file, uint32_t face, const Vec3& point) {
  const std::vector<uint32_t>& vertices = file.faces[face].vertices;
  const std::vector<double> weights = WeightsAt(file, face, point);
  Rgb sum(0.0);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const std::array<float, 3>& h = file.vertices[vertices[k]].irradiance;
    sum += weights[k] * Rgb(h[0], h[1], h[2]);
  }
  return sum;
}

struct PatchLocator::Impl {
  std::vector<SurfaceGrid> grids;                // in the order of their first faces
  std::unordered_map<uint64_t, size_t> grid_of;  // by side
};

PatchLocator::PatchLocator(const PatchFile& file) : impl_(std::make_unique<Impl>()) {
  std::vector<std::vector<uint32_t>> faces;
  for (uint32_t f = 0; f < file.faces.size(); ++f) {
    const auto [place, first] = impl_->grid_of.try_emplace(SideKey(file.faces[f]), faces.size());
    if (first) faces.emplace_back();
    faces[place->second].push_back(f);
  }
  for (std::vector<uint32_t>& list : faces) impl_->grids.emplace_back(file, std::move(list));
}

PatchLocator::PatchLocator(PatchLocator&&) noexcept = default;
PatchLocator& PatchLocator::operator=(PatchLocator&&) noexcept = default;
PatchLocator::~PatchLocator() = default;

bool PatchLocator::Has(uint64_t side_key) const { return impl_->grid_of.contains(side_key); }

std::optional<uint32_t> PatchLocator::Find(uint64_t side_key, const Vec3& point) const {
  const auto place = impl_->grid_of.find(side_key);
  if (place == impl_->grid_of.end()) return std::nullopt;
  const std::optional<Found> found = impl_->grids[place->second].Find(point);
  return found ? std::optional(found->face) : std::nullopt;
}

std::optional<uint32_t> PatchLocator::FindAlong(const Vec3& normal, const Vec3& point) const {
  Found best;
  for (const SurfaceGrid& grid : impl_->grids) {
    if (glm::dot(grid.normal(), normal) < kAlong || !grid.Near(point)) continue;
    const std::optional<Found> found = grid.Find(point);
    if (found && found->outside < best.outside) best = *found;
  }
  return std::isfinite(best.outside) ? std::optional(best.face) : std::nullopt;
}

}  // namespace isolux
