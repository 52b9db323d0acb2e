#include "client/import/prepare.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "client/import/contacts.h"
#include "client/import/coordinates.h"
#include "client/import/covered.h"
#include "client/import/merge.h"
#include "client/import/t_junctions.h"
#include "common/hierarchy/planes.h"
#include "common/util/random.h"

namespace isolux {
namespace {

// Pieces of one polygon, and how many times its polygons a scene may have in the end.
constexpr uint32_t kMostPieces = 256;
constexpr uint64_t kMostGrowth = 8;
// The smallest polygons with contacts that together have no more than this share of the area of all
// are left whole: half dark or not, they change the mean by less than a solve can see.
constexpr double kNegligibleArea = 0.005;
// Over the polygon's diagonal: strips along its border narrower than this are not cut off, and
// contacts shorter than this not cut along. What they could darken is as small a share of the
// polygon.
constexpr double kLeastWidth = 1e-4, kLeastLength = 2e-3;

class Preparer {
 public:
  Preparer(Scene* scene, RepairLog* log, const std::function<std::string(uint32_t)>& line_of)
      : scene_(*scene), log_(*log), line_of_(line_of) {}

  void Run() {
    const TJunctions junctions = CountTJunctions(scene_);
    Note(Repair::kTJunction, junctions.count, junctions.first_polygon);
    const Sheets sheets = FindSheets(scene_, Merge());
    Cut();
    const Uncovered covered = DropCoveredSides(sheets, source_, &scene_);
    Note(Repair::kCovered, covered.sides, FileNumber(covered.first_polygon));
  }

 private:
  uint32_t FileNumber(uint32_t polygon) const { return scene_.polygons[polygon].file_polygon; }
  void Note(Repair kind, uint64_t count, uint32_t file_polygon) {
    log_.Add(kind, count, [&] { return line_of_(file_polygon); });
  }

  // The plane of each polygon that is left.
  std::vector<uint32_t> Merge() {
    std::vector<uint32_t> plane_of = FindPlanes(scene_);
    UnifyCoordinates(&scene_, plane_of);
    const RegionMerge regions = MergeRegions(&scene_, &plane_of);
    Note(Repair::kRegion, regions.gone, regions.first_polygon);
    Note(Repair::kMerged, MergeTrianglePairs(&scene_, &plane_of), 0);
    DropRepeated(&plane_of);
    return plane_of;
  }

  // Merging may make the same polygon of different tessellations of one surface.
  void DropRepeated(std::vector<uint32_t>* plane_of) {
    std::unordered_map<uint64_t, std::vector<uint32_t>> known;  // by hash of the corners
    std::vector<bool> drop(scene_.polygons.size(), false);
    for (uint32_t p = 0; p < drop.size(); ++p) {
      const std::array<uint32_t, 4> loop = FromLeast(scene_.polygons[p]);
      auto& same = known[Hash(Hash(loop[0], loop[1]), Hash(loop[2], loop[3]))];
      drop[p] = std::any_of(same.begin(), same.end(),
                            [&](uint32_t q) { return FromLeast(scene_.polygons[q]) == loop; });
      if (drop[p]) Note(Repair::kDuplicate, 1, FileNumber(p));
      same.push_back(p);
    }
    EraseMarked(drop, &scene_.polygons);
    EraseMarked(drop, plane_of);
  }

  static std::array<uint32_t, 4> FromLeast(const Polygon& polygon) {
    std::array<uint32_t, 4> loop = polygon.vertices;
    const auto end = loop.begin() + polygon.vertex_count();
    std::rotate(loop.begin(), std::min_element(loop.begin(), end), end);
    return loop;
  }

  void Cut() {
    const ContactFinder finder(scene_);
    const auto count = static_cast<uint32_t>(scene_.polygons.size());
    std::vector<double> area(count);
    std::vector<std::vector<CutSegment>> segments(count);
    std::vector<uint32_t> order;
    for (uint32_t p = 0; p < count; ++p) {
      area[p] = SideGeometry(scene_, p, Side::kFront).Area();
      segments[p] = Relevant(p, finder);
      if (!segments[p].empty()) order.push_back(p);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return area[a] < area[b]; });
    double left = kNegligibleArea * std::accumulate(area.begin(), area.end(), 0.0);
    size_t first = 0;
    for (; first < order.size() && area[order[first]] <= left; ++first) {
      left -= area[order[first]];
      Note(Repair::kSmallContact, segments[order[first]].size(), FileNumber(order[first]));
    }
    // The largest first: where the budget ends, what is left uncut is small.
    uint64_t budget = kMostGrowth * count;
    std::vector<CutResult> cuts(count);
    for (size_t i = order.size(); i > first; --i) {
      const uint32_t p = order[i - 1];
      cuts[p] = CutOne(p, segments[p], finder, budget);
      budget -= std::min<uint64_t>(budget, cuts[p].pieces.size());
    }
    Replace(cuts);
  }

  static CutLimits LimitsFor(uint32_t p, const ContactFinder& finder) {
    const double size = finder.bounds(p).Diagonal();
    CutLimits limits;
    limits.pieces = kMostPieces;
    limits.width = std::max(kLeastWidth * size, ContactTolerance(finder.extent_m(), size));
    limits.length = kLeastLength * size;
    return limits;
  }

  std::vector<CutSegment> Relevant(uint32_t p, const ContactFinder& finder) {
    const std::vector<CutSegment> segments = finder.Of(p);
    if (segments.empty()) return {};
    ClippedSegments clipped =
        ClipSegments(SideGeometry(scene_, p, Side::kFront), segments, LimitsFor(p, finder));
    Note(Repair::kSmallContact, clipped.too_short, FileNumber(p));
    return std::move(clipped.segments);
  }

  CutResult CutOne(uint32_t p, std::span<const CutSegment> segments, const ContactFinder& finder,
                   uint64_t budget) {
    CutLimits limits = LimitsFor(p, finder);
    limits.pieces = static_cast<uint32_t>(std::min<uint64_t>(limits.pieces, budget));
    CutResult cut = CutPolygon(SideGeometry(scene_, p, Side::kFront), segments, limits);
    Note(Repair::kContact, cut.contacts, FileNumber(p));
    Note(Repair::kPenetration, cut.penetrations, FileNumber(p));
    Note(Repair::kPieceLimit, cut.complete ? 0 : 1, FileNumber(p));
    return cut;
  }

  void Replace(const std::vector<CutResult>& cuts) {
    std::vector<Polygon> pieces;
    for (uint32_t p = 0; p < cuts.size(); ++p) {
      const Polygon& whole = scene_.polygons[p];
      if (cuts[p].pieces.size() < 2) {
        pieces.push_back(whole);
        source_.push_back(p);
        continue;
      }
      const auto corners = static_cast<size_t>(whole.vertex_count());
      std::vector<uint32_t> vertex(whole.vertices.begin(), whole.vertices.begin() + corners);
      for (size_t i = corners; i < cuts[p].points.size(); ++i) {
        vertex.push_back(static_cast<uint32_t>(scene_.vertices.size()));
        scene_.vertices.push_back(cuts[p].points[i]);
      }
      for (const auto& from : cuts[p].pieces) {
        Polygon piece = whole;
        for (int k = 0; k < 4; ++k) {
          piece.vertices[k] = from[k] == kNoVertex ? kNoVertex : vertex[from[k]];
        }
        pieces.push_back(piece);
        source_.push_back(p);
      }
    }
    scene_.polygons = std::move(pieces);
  }

  Scene& scene_;
  RepairLog& log_;
  const std::function<std::string(uint32_t)>& line_of_;
  std::vector<uint32_t> source_;  // of each polygon: before cutting
};

}  // namespace

void PrepareForTransport(Scene* scene, RepairLog* log,
                         const std::function<std::string(uint32_t)>& line_of) {
  Preparer(scene, log, line_of).Run();
}

}  // namespace isolux
