#include "worker/radiosity/sky_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/util/angles.h"
#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {
namespace {

// Of the area of a cell that a border crosses, the deviation of what one ray says of it: half on
// average is hidden; and thin openings that rays miss. Measured on a room with a window.
constexpr double kBorderDeviation = 0.7;

double SumOf(const Rgb& c) { return c.x + c.y + c.z; }

// Of the grid of a point: where more cells may see the sky, they are joined by fours.
constexpr int kFewestCells = 16, kMostRays = 512;

struct Cell {
  int x = 0, y = 0;
};

void Coarsen(SkyOpenings* openings) {
  const int cells = openings->cells / 2;
  std::vector<uint8_t> joined(static_cast<size_t>(cells) * cells, 0);
  for (int y = 0; y < openings->cells; ++y) {
    for (int x = 0; x < openings->cells; ++x) {
      joined[static_cast<size_t>(y / 2 * cells + x / 2)] |=
          openings->possible[static_cast<size_t>(y * openings->cells + x)];
    }
  }
  openings->cells = cells;
  openings->possible = std::move(joined);
}

}  // namespace

// The square [−1, 1]² over the hemisphere of one point, in grids twice as fine from level to level.
class SkyField::Hemisphere {
 public:
  Hemisphere(const SkyField& field, const LitPoint& point, int cells, int divisions)
      : field_(field),
        point_(point),
        cells_(cells),
        divisions_(divisions),
        random_(Hash(point.seed, 0x5c1u)) {
    const Vec3& n = point.normal;
    side_ = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
    across_ = glm::cross(n, side_);
    for (int level = 0; level <= divisions; ++level) {
      state_.emplace_back(static_cast<size_t>(Cells(level)) * Cells(level), kUnknown);
    }
  }

  // Where a ray through each cell, from anywhere on the polygon, meets the sky.
  std::vector<uint8_t> FromAllOver(const ConvexPolygon& polygon) {
    std::vector<Cell> cells;
    for (int i = 0; i < cells_ * cells_; ++i) cells.push_back({i % cells_, i / cells_});
    Cast(0, cells, &polygon);
    return std::move(state_[0]);
  }

  Seen Look(const SkyOpenings& openings) {
    std::vector<Cell> cells, next;
    for (int i = 0; i < cells_ * cells_; ++i) {
      state_[0][static_cast<size_t>(i)] = kHidden;
      if (openings.possible[static_cast<size_t>(i)] != 0) cells.push_back({i % cells_, i / cells_});
    }
    for (int level = 0; level <= divisions_; ++level) {
      const std::vector<Rgb> radiance = Cast(level, cells, nullptr);
      const double share = std::numbers::pi / (static_cast<double>(Cells(level)) * Cells(level));
      next.clear();
      for (size_t i = 0; i < cells.size(); ++i) {
        const bool border = field_.shadows_ && IsBorder(level, cells[i]);
        if (border && level < divisions_) {
          for (int k = 0; k < 4; ++k) {
            next.push_back({2 * cells[i].x + k % 2, 2 * cells[i].y + k / 2});
          }
          continue;
        }
        seen_.irradiance += share * radiance[i];
        // What a border hides here a cell next to it may show.
        if (border) variance_ += share * share;
      }
      cells.swap(next);
    }
    seen_.deviation = kBorderDeviation * std::sqrt(variance_) * brightest_;
    return seen_;
  }

  uint32_t rays() const { return seen_.rays; }
  static bool IsOpen(uint8_t state) { return state >= kOpen; }

 private:
  static constexpr uint8_t kUnknown = 0, kHidden = 1, kOpen = 2, kMirrored = 3, kGlazed = 4;

  int Cells(int level) const { return cells_ << level; }

  // A ray through each cell, from the point or from all over a polygon: the radiance it meets.
  std::vector<Rgb> Cast(int level, const std::vector<Cell>& cells, const ConvexPolygon* from) {
    std::vector<Rgb> radiance(cells.size(), Rgb(0.0));
    const double width = 2.0 / Cells(level);
    for (size_t first = 0; first < cells.size(); first += RayScene::kPacket) {
      const int count = static_cast<int>(std::min<size_t>(RayScene::kPacket, cells.size() - first));
      RayPacket packet;
      std::array<Vec3, RayScene::kPacket> directions;
      for (int i = 0; i < count; ++i) {
        const Cell& cell = cells[first + static_cast<size_t>(i)];
        const double a = (cell.x + random_.Unit()) * width - 1;
        const auto [x, y] = SquareToDisk(a, (cell.y + random_.Unit()) * width - 1);
        const double z = std::sqrt(std::max(1e-12, 1 - x * x - y * y));
        directions[i] = x * side_ + y * across_ + z * point_.normal;
        Vec3 start = point_.position;
        if (from != nullptr) {
          const double u = random_.Unit();
          start = SamplePolygon(*from, u, random_.Unit());
        }
        packet.Set(
            i, {start, start + field_.far_m_ * directions[i], point_.polygon, RayHit::kNothing});
      }
      const uint32_t open = field_.shadows_ ? field_.rays_.Visible(packet) : packet.valid;
      if (field_.shadows_) seen_.rays += static_cast<uint32_t>(count);
      const bool mirrors = field_.shadows_ && !field_.mirrors_.empty();
      for (int i = 0; i < count; ++i) {
        const size_t at = first + static_cast<size_t>(i);
        const bool is_open = (open >> i & 1) != 0;
        State(level, cells[at]) = is_open ? kOpen : kHidden;
        if (!is_open && mirrors && InMirrors(packet, i, directions[i], &radiance[at])) {
          State(level, cells[at]) = kMirrored;
        }
        if (!is_open) continue;
        radiance[at] = field_.sky_.RadianceFrom(directions[i]);
        if (field_.medium_ != nullptr) {
          radiance[at] *= field_.medium_->FromOutside(point_.position, directions[i]);
        }
        if (field_.panes_ != nullptr) {
          const Vec3 start(packet.from[0][i], packet.from[1][i], packet.from[2][i]);
          const Rgb left = field_.panes_->Along(start, start + field_.far_m_ * directions[i]);
          if (left != Rgb(1.0)) State(level, cells[at]) = kGlazed;
          radiance[at] *= left;
        }
        brightest_ = std::max(brightest_, SumOf(radiance[at]));
      }
    }
    return radiance;
  }

  // Whether a ray that meets something meets the sky by way of mirrors, and with what radiance.
  bool InMirrors(const RayPacket& packet, int i, const Vec3& direction, Rgb* radiance) {
    const Vec3 from(packet.from[0][i], packet.from[1][i], packet.from[2][i]);
    const Escape ray{from, direction, packet.from_polygon[i]};
    const RayEnd end = EndOf(field_.rays_, field_.mirrors_, ray, field_.rays_.Trace({ray}, 1)[0],
                             field_.hierarchy_, field_.panes_);
    seen_.rays += static_cast<uint32_t>(1 + end.reflections);
    if (end.reflections == 0 || end.hit.polygon != RayHit::kNothing) return false;
    *radiance = end.share * field_.sky_.RadianceFrom(end.direction);
    if (field_.medium_ != nullptr) {
      *radiance *= field_.medium_->medium.Along(end.way_m) *
                   field_.medium_->FromOutside(end.from, end.direction);
    }
    if (field_.panes_ != nullptr) {
      *radiance *=
          end.left * field_.panes_->Along(end.from, end.from + field_.far_m_ * end.direction);
    }
    brightest_ = std::max(brightest_, SumOf(*radiance));
    return true;
  }

  uint8_t& State(int level, const Cell& cell) {
    return state_[static_cast<size_t>(level)]
                 [static_cast<size_t>(cell.y) * Cells(level) + static_cast<size_t>(cell.x)];
  }

  // As far as it is known: of the smallest cell that a ray has gone through.
  uint8_t StateAround(int level, Cell cell) {
    while (level > 0 && State(level, cell) == kUnknown) {
      --level;
      cell = {cell.x / 2, cell.y / 2};
    }
    return State(level, cell);
  }

  // Whether a cell next to it sees what it does not, or the other way round.
  bool IsBorder(int level, const Cell& cell) {
    const uint8_t own = State(level, cell);
    for (int k = 0; k < 9; ++k) {
      const Cell other{cell.x + k % 3 - 1, cell.y + k / 3 - 1};
      if (std::min(other.x, other.y) < 0 || std::max(other.x, other.y) >= Cells(level)) continue;
      if (StateAround(level, other) != own) return true;
    }
    return false;
  }

  const SkyField& field_;
  const LitPoint& point_;
  int cells_, divisions_;
  Random random_;
  Vec3 side_{0.0}, across_{0.0};
  std::vector<std::vector<uint8_t>> state_;  // by level
  Seen seen_;
  double variance_ = 0, brightest_ = 0;
};

SkyField::SkyField(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   double far_m, bool shadows, const MediumInBox* medium, const Panes* panes)
    : hierarchy_(hierarchy),
      sky_(hierarchy.scene().sky),
      rays_(rays),
      mirrors_(mirrors),
      far_m_(far_m),
      shadows_(shadows),
      medium_(medium),
      panes_(panes) {}

SkyOpenings SkyField::OpeningsOf(const ConvexPolygon& inside, const LitPoint& any,
                                 int cells) const {
  SkyOpenings openings;
  openings.cells = shadows_ ? cells : kFewestCells;
  openings.possible.assign(static_cast<size_t>(openings.cells) * openings.cells, 1);
  if (!shadows_) return openings;
  Hemisphere hemisphere(*this, any, cells, 0);
  const std::vector<uint8_t> seen = hemisphere.FromAllOver(inside);
  openings.rays = hemisphere.rays();
  // Points of the element differ, and one ray a cell misses some.
  constexpr int kReach = 2;
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      bool open = false;
      for (int v = std::max(0, y - kReach); v <= std::min(cells - 1, y + kReach); ++v) {
        for (int u = std::max(0, x - kReach); u <= std::min(cells - 1, x + kReach); ++u) {
          open |= Hemisphere::IsOpen(seen[static_cast<size_t>(v * cells + u)]);
        }
      }
      openings.possible[static_cast<size_t>(y * cells + x)] = open ? 1 : 0;
    }
  }
  const auto count = [&] { return std::ranges::count(openings.possible, 1); };
  while (openings.cells > kFewestCells && count() > kMostRays) Coarsen(&openings);
  return openings;
}

SkyField::Seen SkyField::At(const LitPoint& point, const SkyOpenings& openings, int finest) const {
  int divisions = 0;
  while (shadows_ && openings.cells << (divisions + 1) <= finest) ++divisions;
  return Hemisphere(*this, point, openings.cells, divisions).Look(openings);
}

}  // namespace isolux
