#include "client/import/cut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/scene/plane_frame.h"

namespace isolux {
namespace {

// A cut that follows segments for less than this share of its length waits until the piece has been
// made smaller.
constexpr double kLeastCoverage = 0.15;
constexpr size_t kMostCandidates = 24;  // lines tried for a piece
// Weights of what a line is chosen by, against the share of it that segments cover.
constexpr double kRoundnessWeight = 0.5, kCrossingWeight = 0.5;
constexpr double kNever = -std::numeric_limits<double>::infinity();

struct Segment {
  Point2 from, to;
};

struct Line {
  Point2 at, direction;  // of length 1
  double Distance(const Point2& p) const { return Cross(direction, p - at); }
};

struct Piece {
  std::vector<uint32_t> corners;
  std::vector<Segment> segments;  // clipped to the piece
};

class Cutter {
 public:
  Cutter(const ConvexPolygon& polygon, const CutLimits& limits)
      : limits_(limits), frame_(polygon.v[0], polygon.Normal()) {
    for (int i = 0; i < polygon.count; ++i) {
      result_.points.push_back(polygon.v[i]);
      flat_.push_back(frame_.Flat(polygon.v[i]));
      whole_.push_back(static_cast<uint32_t>(i));
    }
  }

  ClippedSegments Clip(std::span<const CutSegment> segments) const {
    ClippedSegments result;
    for (const CutSegment& s : segments) {
      const auto inside = Inside(whole_, {frame_.Flat(s.from), frame_.Flat(s.to)});
      if (!inside) continue;
      const Vec3 whole = s.to - s.from;
      const CutSegment clipped{s.from + inside->first * whole, s.from + inside->second * whole,
                               s.penetrates};
      if (glm::length(clipped.to - clipped.from) < limits_.length) {
        ++result.too_short;
      } else {
        result.segments.push_back(clipped);
      }
    }
    return result;
  }

  CutResult Run(std::span<const CutSegment> segments) {
    Piece whole{whole_, {}};
    for (const CutSegment& segment : segments) Take(segment, &whole.segments);
    std::vector<Piece> open{std::move(whole)};
    std::vector<std::vector<uint32_t>> done;
    while (!open.empty()) {
      Piece piece = std::move(open.back());
      open.pop_back();
      if (piece.segments.empty()) {
        done.push_back(std::move(piece.corners));
        continue;
      }
      // A piece of more than four corners becomes two or three.
      if (2 * (open.size() + done.size() + 2) > limits_.pieces) {
        result_.complete = false;
        piece.segments.clear();
        open.push_back(std::move(piece));
        continue;
      }
      Divide(std::move(piece), &open);
    }
    for (const auto& corners : done) Emit(corners);
    return std::move(result_);
  }

 private:
  void Take(const CutSegment& from, std::vector<Segment>* segments) {
    segments->push_back({frame_.Flat(from.from), frame_.Flat(from.to)});
    ++(from.penetrates ? result_.penetrations : result_.contacts);
  }

  // The part of a segment, from 0 to 1, that is inside a piece; nothing where that is empty or runs
  // along the border.
  std::optional<std::pair<double, double>> Inside(const std::vector<uint32_t>& corners,
                                                  const Segment& segment) const {
    const Point2 whole = segment.to - segment.from;
    const double length = Length(whole);
    if (!(length > limits_.width)) return std::nullopt;
    double low = 0, high = 1;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Line side = Side(corners, i);
      const double a = side.Distance(segment.from), b = side.Distance(segment.to);
      if (a < 0 && b < 0) return std::nullopt;
      if (a < 0) low = std::max(low, a / (a - b));
      if (b < 0) high = std::min(high, a / (a - b));
    }
    if ((high - low) * length <= limits_.width) return std::nullopt;
    const Point2 from = segment.from + low * whole, to = segment.from + high * whole;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Line side = Side(corners, i);
      if (side.Distance(from) <= limits_.width && side.Distance(to) <= limits_.width)
        return std::nullopt;
    }
    return std::pair(low, high);
  }

  Line Side(const std::vector<uint32_t>& corners, size_t i) const {
    const Point2& from = flat_[corners[i]];
    const Point2 along = flat_[corners[(i + 1) % corners.size()]] - from;
    const double length = Length(along);
    return {from, length > 0 ? (1 / length) * along : Point2{1, 0}};
  }

  static Line Through(const Segment& s) {
    const Point2 along = s.to - s.from;
    return {s.from, (1 / Length(along)) * along};
  }

  // The parts of a piece left and right of a line; a corner nearer than the width lies on it.
  // Without `create`, new points are only measured.
  struct Parts {
    std::vector<Point2> left, right;
  };
  Parts Measure(const std::vector<uint32_t>& corners, const Line& line) const {
    Parts parts;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Point2& a = flat_[corners[i]];
      const Point2& b = flat_[corners[(i + 1) % corners.size()]];
      const double da = Snapped(line, a), db = Snapped(line, b);
      if (da >= 0) parts.left.push_back(a);
      if (da <= 0) parts.right.push_back(a);
      if (da * db >= 0) continue;
      const Point2 cut = a + (da / (da - db)) * (b - a);
      parts.left.push_back(cut);
      parts.right.push_back(cut);
    }
    return parts;
  }

  double Snapped(const Line& line, const Point2& p) const {
    const double distance = line.Distance(p);
    return std::abs(distance) <= limits_.width ? 0 : distance;
  }

  static double Area(const std::vector<Point2>& polygon) {
    double twice = 0;
    for (size_t i = 1; i + 1 < polygon.size(); ++i) {
      twice += Cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    }
    return 0.5 * twice;
  }

  // 4π area / perimeter².
  static double Roundness(const std::vector<Point2>& polygon) {
    if (polygon.size() < 3) return 0;
    double perimeter = 0;
    for (size_t i = 0; i < polygon.size(); ++i) {
      perimeter += Length(polygon[(i + 1) % polygon.size()] - polygon[i]);
    }
    return 4 * M_PI * Area(polygon) / (perimeter * perimeter);
  }

  struct Choice {
    Line line;
    double coverage = 0, score = kNever;
  };

  Choice Judge(const Piece& piece, const Line& line) const {
    const Parts parts = Measure(piece.corners, line);
    Choice choice{line};
    if (parts.left.size() < 3 || parts.right.size() < 3) return choice;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Point2& p : parts.left) {
      if (std::abs(line.Distance(p)) > limits_.width) continue;
      const double t = Dot(line.direction, p - line.at);
      low = std::min(low, t);
      high = std::max(high, t);
    }
    double covered = 0, crossed = 0;
    for (const Segment& s : piece.segments) {
      const double a = Snapped(line, s.from), b = Snapped(line, s.to);
      if (a == 0 && b == 0) covered += Length(s.to - s.from);
      if (a * b < 0) crossed += 1;
    }
    choice.coverage = std::min(1.0, covered / std::max(high - low, 1e-300));
    choice.score = choice.coverage +
                   kRoundnessWeight * std::min(Roundness(parts.left), Roundness(parts.right)) -
                   kCrossingWeight * crossed / static_cast<double>(piece.segments.size());
    return choice;
  }

  Choice BestLine(const Piece& piece) const {
    std::vector<const Segment*> order;
    for (const Segment& s : piece.segments) order.push_back(&s);
    std::stable_sort(order.begin(), order.end(), [](const Segment* a, const Segment* b) {
      return Length(a->to - a->from) > Length(b->to - b->from);
    });
    Choice best;
    for (size_t i = 0; i < std::min(order.size(), kMostCandidates); ++i) {
      const Choice choice = Judge(piece, Through(*order[i]));
      if (choice.score > best.score) best = choice;
    }
    return best;
  }

  // Across the longest side, beside all segments where that leaves at least a fifth, else through
  // the middle.
  Line AcrossLongest(const Piece& piece) const {
    size_t longest = 0;
    double length = 0;
    for (size_t i = 0; i < piece.corners.size(); ++i) {
      const double l =
          Length(flat_[piece.corners[(i + 1) % piece.corners.size()]] - flat_[piece.corners[i]]);
      if (l <= length) continue;
      length = l;
      longest = i;
    }
    const Line side = Side(piece.corners, longest);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Segment& s : piece.segments) {
      for (const Point2& p : {s.from, s.to}) {
        low = std::min(low, Dot(side.direction, p - side.at));
        high = std::max(high, Dot(side.direction, p - side.at));
      }
    }
    double at = 0.5 * length;
    if (low < at && high > at) {
      if (low >= 0.2 * length) {
        at = low;
      } else if (high <= 0.8 * length) {
        at = high;
      }
    }
    return {side.at + at * side.direction, {-side.direction.y, side.direction.x}};
  }

  void Divide(Piece piece, std::vector<Piece>* open) {
    Choice best = BestLine(piece);
    if (best.coverage < kLeastCoverage) {
      const Choice across = Judge(piece, AcrossLongest(piece));
      if (across.score > kNever) best = across;
    }
    if (best.score == kNever) {  // every cut would take off less than the width
      piece.segments.clear();
      open->push_back(std::move(piece));
      return;
    }
    std::array<Piece, 2> parts = Split(piece.corners, best.line);
    for (Piece& part : parts) {
      for (const Segment& s : piece.segments) {
        const auto inside = Inside(part.corners, s);
        if (!inside) continue;
        const Point2 whole = s.to - s.from;
        part.segments.push_back({s.from + inside->first * whole, s.from + inside->second * whole});
      }
    }
    open->push_back(std::move(parts[1]));
    open->push_back(std::move(parts[0]));
  }

  // As Measure, with new points made. They lie on sides of the piece in space, too.
  std::array<Piece, 2> Split(const std::vector<uint32_t>& corners, const Line& line) {
    std::array<Piece, 2> parts;
    for (size_t i = 0; i < corners.size(); ++i) {
      const uint32_t a = corners[i], b = corners[(i + 1) % corners.size()];
      const double da = Snapped(line, flat_[a]), db = Snapped(line, flat_[b]);
      if (da >= 0) parts[0].corners.push_back(a);
      if (da <= 0) parts[1].corners.push_back(a);
      if (da * db >= 0) continue;
      const double t = da / (da - db);
      const auto cut = static_cast<uint32_t>(flat_.size());
      flat_.push_back(flat_[a] + t * (flat_[b] - flat_[a]));
      result_.points.push_back(result_.points[a] + t * (result_.points[b] - result_.points[a]));
      parts[0].corners.push_back(cut);
      parts[1].corners.push_back(cut);
    }
    return parts;
  }

  std::vector<Point2> Flat(const std::vector<uint32_t>& corners) const {
    std::vector<Point2> points;
    for (const uint32_t c : corners) points.push_back(flat_[c]);
    return points;
  }

  // Divides what has more than four corners, or is no quad that the solver takes, so that the worst
  // part is as round as can be.
  void Emit(const std::vector<uint32_t>& corners) {
    const size_t n = corners.size();
    if (n == 3 || (n == 4 && IsGoodQuad(corners))) {
      std::array<uint32_t, 4> piece{kNoVertex, kNoVertex, kNoVertex, kNoVertex};
      std::copy(corners.begin(), corners.end(), piece.begin());
      result_.pieces.push_back(piece);
      return;
    }
    std::array<std::vector<uint32_t>, 2> best;
    double best_score = kNever;
    for (size_t i = 0; i < n; ++i) {
      for (size_t k = i + 2; k < n && (i > 0 || k + 1 < n); ++k) {
        const std::vector<uint32_t> one(corners.begin() + static_cast<ptrdiff_t>(i),
                                        corners.begin() + static_cast<ptrdiff_t>(k) + 1);
        std::vector<uint32_t> two(corners.begin() + static_cast<ptrdiff_t>(k), corners.end());
        two.insert(two.end(), corners.begin(), corners.begin() + static_cast<ptrdiff_t>(i) + 1);
        const double score = std::min(Roundness(Flat(one)), Roundness(Flat(two)));
        if (score <= best_score) continue;
        best_score = score;
        best = {one, two};
      }
    }
    Emit(best[0]);
    Emit(best[1]);
  }

  bool IsGoodQuad(const std::vector<uint32_t>& corners) const {
    ConvexPolygon quad{4, {}};
    for (int i = 0; i < 4; ++i) quad.v[i] = result_.points[corners[i]];
    return IsPlanar(quad) && IsConvex(quad);
  }

  CutLimits limits_;
  PlaneFrame frame_;
  std::vector<uint32_t> whole_;
  std::vector<Point2> flat_;  // of result_.points
  CutResult result_;
};

}  // namespace

ClippedSegments ClipSegments(const ConvexPolygon& polygon, std::span<const CutSegment> segments,
                             const CutLimits& limits) {
  return Cutter(polygon, limits).Clip(segments);
}

CutResult CutPolygon(const ConvexPolygon& polygon, std::span<const CutSegment> segments,
                     const CutLimits& limits) {
  return Cutter(polygon, limits).Run(segments);
}

}  // namespace isolux
