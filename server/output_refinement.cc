#include "server/output_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/hierarchy/element.h"
#include "server/weld.h"

namespace isolux {
namespace {

// Corners of one leaf's elements as one point: what rounding moves a midpoint.
constexpr double kSameCorner = 1e-9;
// A tolerance never goes below that of this share of the mean irradiance: dark corners are not
// worth points.
constexpr double kDarkShare = 0.05;
// The accuracy is that of the mean; a single bend may be this much larger. Against a tolerance of
// one accuracy the Cornell box at 5 % takes 42 % fewer elements, and its error grows from 2.64
// to 2.70 %.
constexpr double kBend = 2;
// When a leaf is divided, before anything is known of its inside. A field that varies by r over a
// leaf bends by about r/8 (a parabola) to r/4 (a corner) at its middle.
constexpr double kContrast = 4;    // range of its corners, in tolerances
constexpr double kMeanOffset = 2;  // its mean irradiance against the mean of its corners, the same
constexpr double kLargeLeaf = 1.0 / 12;  // longest side over the scene's extent
// The share of the accuracy that interpolation may take before further waves follow.
constexpr double kInterpolation = 0.25;
// How far an element is off on average, over how far its corners were from what was expected there.
constexpr double kOffInside = 0.25;

using Element = OutputElement;

// An element to be gathered: what interpolation over the one it is cut from says of its corners.
struct Candidate {
  NodeId id;
  uint32_t leaf = 0;
  float tolerance = 0;  // W/m², sum of channels
  std::array<Channels, 4> expected{};
};

// An element that was gathered, and how far its corners are from what was expected there.
struct Piece {
  Element element;
  double area_m2 = 0;
  double off = 0;   // W/m², sum of channels; unknown for whole leaves
  double bend = 0;  // the same in tolerances
};

double Sum(const Channels& c) { return static_cast<double>(c[0]) + c[1] + c[2]; }

double TotalIrradiance(const LeafRecord& leaf) {
  return leaf.irradiance[0] + leaf.irradiance[1] + leaf.irradiance[2];
}

double Difference(const Channels& a, const Channels& b) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += std::abs(static_cast<double>(a[c]) - b[c]);
  return sum;
}

// The waves: which elements there are, and what was gathered at their corners.
class Refinement {
 public:
  Refinement(const Hierarchy& hierarchy, const Snapshot& snapshot, const OutputMeshOptions& options,
             const GatherFunction& gather)
      : hierarchy_(hierarchy),
        leaves_(snapshot.leaves),
        options_(options),
        gather_(gather),
        points_(kSameCorner * hierarchy.extent_m(), hierarchy.clusters()[0].bounds.low,
                2 * leaves_.size() + 16) {}

  Result<OutputElements> Run(const std::vector<uint32_t>& leaves) {
    FindMean();
    std::vector<Candidate> wave;
    for (const uint32_t i : leaves) wave.push_back({leaves_[i].id, i, 0, {}});
    ASSIGN_OR_RETURN(std::vector<Piece> pieces, Gather(wave));
    RemoveDarkSurfaces(&pieces);
    double power_w = 0;
    for (Piece& piece : pieces) {
      piece.off = 0;
      piece.bend = LeafBend(piece.element);
      power_w += piece.area_m2 * TotalIrradiance(leaves_[piece.element.leaf]);
    }
    const double allowed_w = kInterpolation * options_.accuracy * power_w;
    for (int w = 1; w < options_.waves + options_.further_waves; ++w) {
      std::vector<size_t> chosen =
          w < options_.waves ? Bending(pieces) : LeavingMost(pieces, allowed_w - left_w_);
      KeepToTheLimit(pieces, &chosen);
      if (chosen.empty()) break;
      wave = Divide(pieces, chosen);
      ASSIGN_OR_RETURN(pieces, Gather(wave));
    }
    for (const Piece& piece : pieces) Settle(piece);
    std::sort(done_.begin(), done_.end(),
              [](const Element& a, const Element& b) { return a.id < b.id; });
    if (options_.keep_points) KeepPoints();
    return OutputElements{std::move(done_), std::move(kept_), power_w > 0 ? left_w_ / power_w : 0};
  }

 private:
  // Mean over all sides that take part, sum of channels.
  void FindMean() {
    double power = 0, area = 0;
    for (const LeafRecord& leaf : leaves_) {
      const double part =
          hierarchy_.surface_area_m2(leaf.id.surface) * std::ldexp(1.0, -leaf.id.level());
      power += part * TotalIrradiance(leaf);
      area += part;
    }
    mean_ = area > 0 ? power / area : 0;
  }

  double Tolerance(double irradiance) const {
    return kBend * options_.accuracy * std::max(irradiance, kDarkShare * mean_);
  }

  // Gathers a wave. Corners that an element of the leaf has had before are known.
  Result<std::vector<Piece>> Gather(const std::vector<Candidate>& wave) {
    std::vector<NodeId> ids;
    std::vector<uint8_t> wanted;
    std::vector<std::array<uint32_t, 4>> vertices(wave.size());
    std::vector<Piece> pieces(wave.size());
    for (size_t i = 0; i < wave.size(); ++i) {
      uint8_t corners = 0;
      const ConvexPolygon shape =
          ElementGeometry(hierarchy_.geometry(wave[i].id.surface), wave[i].id.path);
      pieces[i].area_m2 = shape.Area();
      for (int k = 0; k < shape.count; ++k) {
        vertices[i][k] = points_.Vertex(shape.v[k], wave[i].leaf);
        if (vertices[i][k] < irradiance_.size()) continue;
        irradiance_.emplace_back();
        corners |= static_cast<uint8_t>(1U << k);
      }
      if (corners == 0) continue;
      ids.push_back(wave[i].id);
      wanted.push_back(corners);
    }
    RETURN_IF_ERROR(GatherCorners(ids, wanted, wave, vertices));
    for (size_t i = 0; i < wave.size(); ++i) {
      Piece& piece = pieces[i];
      piece.element = {wave[i].id, wave[i].leaf, {}};
      for (int k = 0; k < hierarchy_.geometry(wave[i].id.surface).count; ++k) {
        piece.element.irradiance[k] = irradiance_[vertices[i][k]];
        piece.off =
            std::max(piece.off, Difference(piece.element.irradiance[k], wave[i].expected[k]));
      }
      if (piece.off > 0) piece.bend = piece.off / wave[i].tolerance;
    }
    return pieces;
  }

  // The wanted corners of these elements of the wave; what is no number is taken from the leaf.
  Status GatherCorners(const std::vector<NodeId>& ids, const std::vector<uint8_t>& wanted,
                       const std::vector<Candidate>& wave,
                       const std::vector<std::array<uint32_t, 4>>& vertices) {
    if (ids.empty()) return {};
    ASSIGN_OR_RETURN(const std::vector<double> values, gather_(ids, wanted));
    if (values.size() != 12 * ids.size()) {
      return MakeStatus(StatusCode::kInternal, "gathered {} values at the corners of {} elements",
                        values.size(), ids.size());
    }
    OutputPoints::Wave kept;
    for (size_t i = 0, asked = 0; i < wave.size() && asked < ids.size(); ++i) {
      if (!(wave[i].id == ids[asked])) continue;
      for (int k = 0; k < 4; ++k) {
        if ((wanted[asked] >> k & 1) == 0) continue;
        if (options_.keep_points) kept.points.push_back(vertices[i][k]);
        for (int c = 0; c < 3; ++c) {
          const double value = values[12 * asked + 3 * k + c];
          irradiance_[vertices[i][k]][c] = static_cast<float>(
              std::isfinite(value) ? std::max(0.0, value) : leaves_[wave[i].leaf].irradiance[c]);
        }
      }
      ++asked;
    }
    if (!options_.keep_points) return {};
    kept.elements = ids;
    kept.corners = wanted;
    kept_.waves.push_back(std::move(kept));
    return {};
  }

  // The corners of what is done, as points.
  void KeepPoints() {
    for (const Element& element : done_) {
      const ConvexPolygon shape =
          ElementGeometry(hierarchy_.geometry(element.id.surface), element.id.path);
      OutputPoints::Cornered& kept = kept_.elements.emplace_back();
      kept.id = element.id;
      for (int k = 0; k < shape.count; ++k) {
        kept.points[k] = points_.Vertex(shape.v[k], element.leaf);
      }
    }
    kept_.count = static_cast<uint32_t>(irradiance_.size());
  }

  // A surface on which nothing arrives and that does not emit is left out.
  void RemoveDarkSurfaces(std::vector<Piece>* pieces) const {
    std::vector<bool> lit(hierarchy_.surfaces().size(), false);
    for (const Piece& piece : *pieces) {
      const Element& element = piece.element;
      double light = isolux::Sum(hierarchy_.surfaces()[element.id.surface].exitance);
      for (int c = 0; c < 3; ++c) light += leaves_[element.leaf].irradiance[c];
      for (const Channels& corner : element.irradiance) light += Sum(corner);
      if (light > 0) lit[element.id.surface] = true;
    }
    // What arrives on one side of a sheet is seen on the other.
    if (!options_.sheets.empty()) {
      for (uint32_t s = 0; s < lit.size(); ++s) {
        const uint32_t behind = options_.sheets.PartnerOf(s);
        if (behind != TranslucentSheets::kNone && (lit[s] || lit[behind])) {
          lit[s] = lit[behind] = true;
        }
      }
    }
    std::erase_if(*pieces, [&](const Piece& piece) { return !lit[piece.element.id.surface]; });
  }

  // Whether a leaf may bend, in tolerances (above 1: likely), from its corners, mean and size.
  double LeafBend(const Element& piece) const {
    const int corners = hierarchy_.geometry(piece.id.surface).count;
    const LeafRecord& leaf = leaves_[piece.leaf];
    double low = INFINITY, high = 0, offset = 0, total = 0;
    for (int k = 0; k < corners; ++k) {
      low = std::min(low, Sum(piece.irradiance[k]));
      high = std::max(high, Sum(piece.irradiance[k]));
    }
    for (int c = 0; c < 3; ++c) {
      double mean = 0;
      for (int k = 0; k < corners; ++k) mean += piece.irradiance[k][c] / corners;
      offset += std::abs(mean - leaf.irradiance[c]);
      total += leaf.irradiance[c];
    }
    if (!(high > 0) && !(total > 0)) return 0;  // in the dark: nothing to show
    const double tolerance = Tolerance(0.5 * (low + high));
    const ConvexPolygon shape =
        ElementGeometry(hierarchy_.geometry(piece.id.surface), piece.id.path);
    const int i = LongestSide(shape);
    const double size = glm::length(shape.v[(i + 1) % shape.count] - shape.v[i]);
    return std::max({(high - low) / (kContrast * tolerance), offset / (kMeanOffset * tolerance),
                     size / (kLargeLeaf * hierarchy_.extent_m())});
  }

  bool CanBeDivided(const Piece& piece) const { return piece.element.id.level() + 2 <= kMaxLevel; }

  // What interpolation leaves, W.
  static double Left(const Piece& piece) { return kOffInside * piece.off * piece.area_m2; }

  // The pieces that bend by more than their tolerance.
  std::vector<size_t> Bending(const std::vector<Piece>& pieces) const {
    std::vector<size_t> chosen;
    for (size_t i = 0; i < pieces.size(); ++i) {
      if (pieces[i].bend > 1 && CanBeDivided(pieces[i])) chosen.push_back(i);
    }
    return chosen;
  }

  // The fewest pieces without which the others leave no more than this.
  std::vector<size_t> LeavingMost(const std::vector<Piece>& pieces, double allowed_w) const {
    double left_w = 0;
    std::vector<size_t> chosen(pieces.size());
    std::iota(chosen.begin(), chosen.end(), size_t{0});
    for (const Piece& piece : pieces) left_w += Left(piece);
    std::erase_if(chosen,
                  [&](size_t i) { return pieces[i].bend <= 1 || !CanBeDivided(pieces[i]); });
    std::stable_sort(chosen.begin(), chosen.end(),
                     [&](size_t a, size_t b) { return Left(pieces[a]) > Left(pieces[b]); });
    size_t count = 0;
    while (count < chosen.size() && left_w > allowed_w) left_w -= Left(pieces[chosen[count++]]);
    chosen.resize(count);
    return chosen;
  }

  // Where the limit does not let all be cut, those are that bend most over the largest area.
  void KeepToTheLimit(const std::vector<Piece>& pieces, std::vector<size_t>* chosen) const {
    const uint64_t count = done_.size() + pieces.size();
    const uint64_t room = count < options_.max_elements ? (options_.max_elements - count) / 3 : 0;
    if (chosen->size() <= room) return;
    std::stable_sort(chosen->begin(), chosen->end(), [&](size_t a, size_t b) {
      return pieces[a].bend * pieces[a].area_m2 > pieces[b].bend * pieces[b].area_m2;
    });
    chosen->resize(room);
  }

  void Settle(const Piece& piece) {
    done_.push_back(piece.element);
    left_w_ += Left(piece);
  }

  // Cuts the chosen pieces into four; the others are done.
  std::vector<Candidate> Divide(const std::vector<Piece>& pieces,
                                const std::vector<size_t>& chosen) {
    std::vector<bool> cut(pieces.size(), false);
    for (const size_t i : chosen) cut[i] = true;
    std::vector<Candidate> wave;
    wave.reserve(4 * chosen.size());
    for (size_t i = 0; i < pieces.size(); ++i) {
      if (cut[i]) {
        AddQuarters(pieces[i].element, &wave);
      } else {
        Settle(pieces[i]);
      }
    }
    return wave;
  }

  void AddQuarters(const Element& element, std::vector<Candidate>* wave) const {
    const Field whole{ElementGeometry(hierarchy_.geometry(element.id.surface), element.id.path),
                      element.irradiance};
    double mean = 0;
    for (int k = 0; k < whole.shape.count; ++k) {
      mean += Sum(element.irradiance[k]) / whole.shape.count;
    }
    const auto tolerance =
        static_cast<float>(std::max<double>(Tolerance(mean), std::numeric_limits<float>::min()));
    const std::array<Field, 2> halves = Cut(whole);
    for (int h = 0; h < 2; ++h) {
      const std::array<Field, 2> quarters = Cut(halves[h]);
      for (int q = 0; q < 2; ++q) {
        wave->push_back({element.id.Child(h).Child(q), element.leaf, tolerance, quarters[q].value});
      }
    }
  }

  const Hierarchy& hierarchy_;
  const std::vector<LeafRecord>& leaves_;
  const OutputMeshOptions& options_;
  const GatherFunction& gather_;
  Welder points_;                     // corners; a leaf is a group
  std::vector<Channels> irradiance_;  // of points_
  double mean_ = 0;
  OutputPoints kept_;
  std::vector<Element> done_;
  double left_w_ = 0;  // what interpolation leaves in them
};

}  // namespace

Result<OutputElements> RefineOutput(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                    const std::vector<uint32_t>& leaves,
                                    const OutputMeshOptions& options,
                                    const GatherFunction& gather) {
  return Refinement(hierarchy, snapshot, options, gather).Run(leaves);
}

}  // namespace isolux
