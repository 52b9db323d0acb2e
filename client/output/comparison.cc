#include "client/output/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <unordered_map>
#include <vector>

#include "client/output/interpolate.h"
#include "common/util/random.h"
#include "common/vec.h"

namespace isolux {
namespace {

constexpr double kDarkShare = 0.05;  // of the mean: the least that a local error is relative to
constexpr double kNearby = 1e-4;     // of a surface's extent: what rounding puts beside a face
constexpr int kMostCellsASide = 2048;

uint64_t KeyOf(const PatchFace& face) { return uint64_t{face.polygon} << 1 | face.side; }

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

Rgb IrradianceAt(const PatchFile& file, uint32_t face, const Vec3& point) {
  const std::vector<uint32_t>& vertices = file.faces[face].vertices;
  const std::vector<Vec3> corners = CornersOf(file, file.faces[face]);
  std::vector<double> weights(vertices.size());
  MeanValueWeights(corners, point, weights);
  Rgb sum(0.0);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const std::array<float, 3>& h = file.vertices[vertices[k]].irradiance;
    sum += weights[k] * Rgb(h[0], h[1], h[2]);
  }
  return sum;
}

// The faces of one side of one file polygon on a grid in their plane.
class SurfaceGrid {
 public:
  SurfaceGrid(const PatchFile& file, std::vector<uint32_t> faces)
      : file_(&file), faces_(std::move(faces)) {
    Vec3 normal(0.0);
    for (const uint32_t f : faces_) normal += AreaVector(CornersOf(file, file.faces[f]));
    const double length = glm::length(normal);
    normal = length > 0 ? normal / length : Vec3(0, 0, 1);
    const Vec3 helper = std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    axes_[0] = glm::normalize(glm::cross(normal, helper));
    axes_[1] = glm::cross(normal, axes_[0]);
    Fill();
  }

  // The face that contains the point, or comes within rounding of it.
  const uint32_t* Find(const Vec3& point) const {
    const std::array<int, 2> cell{Cell(0, glm::dot(point, axes_[0])),
                                  Cell(1, glm::dot(point, axes_[1]))};
    const uint32_t* best = nullptr;
    double best_inside = -kNearby * extent_;
    const size_t c =
        static_cast<size_t>(cell[1]) * static_cast<size_t>(size_) + static_cast<size_t>(cell[0]);
    for (uint32_t i = first_[c]; i < first_[c + 1]; ++i) {
      const double inside = Inside(faces_[entries_[i]], point);
      if (inside > best_inside) {
        best_inside = inside;
        best = &faces_[entries_[i]];
      }
    }
    return best;
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
        for (int d = 0; d < 2; ++d) {
          const double x = glm::dot(file_->vertices[v].position, axes_[d]);
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

  // Distance to the nearest side, positive inside; less what the point lies off the plane.
  double Inside(uint32_t face, const Vec3& point) const {
    const std::vector<Vec3> corners = CornersOf(*file_, file_->faces[face]);
    const Vec3 area = AreaVector(corners);
    const double length = glm::length(area);
    if (!(length > 0)) return -INFINITY;
    const Vec3 normal = area / length;
    double inside = INFINITY;
    for (size_t k = 0; k < corners.size(); ++k) {
      const Vec3 side = corners[(k + 1) % corners.size()] - corners[k];
      const double side_length = glm::length(side);
      if (!(side_length > 0)) continue;
      inside =
          std::min(inside, glm::dot(glm::cross(normal, side), point - corners[k]) / side_length);
    }
    return inside - std::abs(glm::dot(normal, point - corners[0]));
  }

  const PatchFile* file_;
  std::vector<uint32_t> faces_;
  std::array<Vec3, 2> axes_{};
  std::array<double, 2> low_{}, scale_{};
  double extent_ = 0;
  int size_ = 1;
  std::vector<uint32_t> first_, entries_;  // of each cell: places in faces_
};

class Locator {
 public:
  explicit Locator(const PatchFile& file) {
    std::unordered_map<uint64_t, std::vector<uint32_t>> faces;
    for (uint32_t f = 0; f < file.faces.size(); ++f) faces[KeyOf(file.faces[f])].push_back(f);
    for (auto& [key, list] : faces) grids_.try_emplace(key, file, std::move(list));
  }
  bool Has(uint64_t key) const { return grids_.contains(key); }
  const uint32_t* Find(uint64_t key, const Vec3& point) const {
    const auto grid = grids_.find(key);
    return grid != grids_.end() ? grid->second.Find(point) : nullptr;
  }

 private:
  std::unordered_map<uint64_t, SurfaceGrid> grids_;
};

// Where points fall: faces of the second file, and those of the first on surfaces only it has.
struct Target {
  const PatchFile* file;
  uint32_t face;
  double area_up_to;  // of all targets up to and with this one
};

std::vector<Target> MakeTargets(const PatchFile& a, const PatchFile& b, const Locator& in_b) {
  std::vector<Target> targets;
  double area = 0;
  const auto add = [&](const PatchFile& file, uint32_t f) {
    area += glm::length(AreaVector(CornersOf(file, file.faces[f])));
    targets.push_back({&file, f, area});
  };
  for (uint32_t f = 0; f < b.faces.size(); ++f) add(b, f);
  for (uint32_t f = 0; f < a.faces.size(); ++f) {
    if (!in_b.Has(KeyOf(a.faces[f]))) add(a, f);
  }
  return targets;
}

// Uniform over the face.
Vec3 PointOn(std::span<const Vec3> corners, Random& random) {
  double rest = 2 * random.Unit() * glm::length(AreaVector(corners));
  size_t i = 1;
  for (; i + 2 < corners.size(); ++i) {
    const double part =
        glm::length(glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]));
    if (rest < part) break;
    rest -= part;
  }
  double u = random.Unit(), v = random.Unit();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return corners[0] + u * (corners[i] - corners[0]) + v * (corners[i + 1] - corners[0]);
}

}  // namespace

Result<Comparison> Compare(const PatchFile& a, const PatchFile& b,
                           const ComparisonOptions& options) {
  const Locator in_a(a), in_b(b);
  const std::vector<Target> targets = MakeTargets(a, b, in_b);
  const double area = targets.empty() ? 0 : targets.back().area_up_to;
  if (!(area > 0)) return Error(StatusCode::kInvalidArgument, "neither solution has any area");

  Comparison result;
  result.samples = options.samples;
  std::vector<double> errors(options.samples), values(options.samples);
  size_t t = 0;
  for (uint64_t i = 0; i < options.samples; ++i) {
    // One point in each of equal parts of the area.
    Random random(Hash(options.seed, i));
    const double place =
        (static_cast<double>(i) + random.Unit()) * (area / static_cast<double>(options.samples));
    while (t + 1 < targets.size() && targets[t].area_up_to <= place) ++t;
    const PatchFile& file = *targets[t].file;
    const PatchFace& face = file.faces[targets[t].face];
    const Vec3 point = PointOn(CornersOf(file, face), random);
    const Rgb here = IrradianceAt(file, targets[t].face, point);
    Rgb there(0.0);
    if (const uint32_t* other = &file == &b ? in_a.Find(KeyOf(face), point) : nullptr) {
      there = IrradianceAt(a, *other, point);
    } else {
      ++result.unmatched;
    }
    errors[i] = Sum(glm::abs(here - there));
    values[i] = &file == &b ? Sum(here) : 0;
  }

  const auto n = static_cast<double>(options.samples);
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  if (!(mean > 0)) {
    return Error(StatusCode::kInvalidArgument, "the second solution has no irradiance");
  }
  double sum = 0, squares = 0, largest = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    sum += errors[i];
    squares += errors[i] * errors[i];
    largest = std::max(largest, errors[i]);
    errors[i] /= std::max(values[i], kDarkShare * mean);
  }
  result.l1_relative = sum / n / mean;
  result.rms_relative = std::sqrt(squares / n) / mean;
  result.max_relative = largest / mean;
  const auto place = errors.begin() + static_cast<std::ptrdiff_t>(0.95 * n);
  std::nth_element(errors.begin(), place, errors.end());
  result.p95_local = *place;
  return result;
}

}  // namespace isolux
