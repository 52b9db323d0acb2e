#include "client/output/comparison.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "client/output/patch_locator.h"
#include "common/util/random.h"
#include "common/vec.h"

namespace isolux {
namespace {

constexpr double kDarkShare = 0.05;  // of the mean: the least that a local error is relative to
constexpr double kNormalMean = 2 / 3.14159265358979324;  // (mean of |x|)² over mean of x², normal x

// Where points fall: faces of the second file, and those of the first on surfaces only it has.
struct Target {
  const PatchFile* file;
  uint32_t face;
  double area_up_to;  // of all targets up to and with this one
};

std::vector<Target> MakeTargets(const PatchFile& a, const PatchFile& b, const PatchLocator& in_b) {
  std::vector<Target> targets;
  double area = 0;
  const auto add = [&](const PatchFile& file, uint32_t f) {
    area += glm::length(AreaVector(CornersOf(file, file.faces[f])));
    targets.push_back({&file, f, area});
  };
  for (uint32_t f = 0; f < b.faces.size(); ++f) add(b, f);
  for (uint32_t f = 0; f < a.faces.size(); ++f) {
    if (!in_b.Has(SideKey(a.faces[f]))) add(a, f);
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

// Calls add(face of a, face of b, point) at seeded points, one in each of equal parts of the area;
// of a solution that has no such surface there is no face.
template <typename Add>
Status Sample(const PatchFile& a, const PatchFile& b, const ComparisonOptions& options,
              const Add& add) {
  const PatchLocator in_a(a), in_b(b);
  const std::vector<Target> targets = MakeTargets(a, b, in_b);
  const double area = targets.empty() ? 0 : targets.back().area_up_to;
  if (!(area > 0)) return {StatusCode::kInvalidArgument, "neither solution has any area"};
  size_t t = 0;
  for (uint64_t i = 0; i < options.samples; ++i) {
    Random random(Hash(options.seed, i));
    const double place =
        (static_cast<double>(i) + random.Unit()) * (area / static_cast<double>(options.samples));
    while (t + 1 < targets.size() && targets[t].area_up_to <= place) ++t;
    const uint32_t f = targets[t].face;
    const PatchFile& file = *targets[t].file;
    const PatchFace& face = file.faces[f];
    const Vec3 point = PointOn(CornersOf(file, face), random);
    if (&file == &b) {
      add(in_a.Find(SideKey(face), point), std::optional<uint32_t>(f), point);
    } else {
      add(std::optional<uint32_t>(f), std::optional<uint32_t>(), point);
    }
  }
  return {};
}

}  // namespace

void ErrorTally::Add(const Rgb& found, const Rgb& expected, const Rgb& deviation) {
  double error = 0;
  for (int c = 0; c < 3; ++c) {
    // The mean of |x + noise| is about √(x² + 2/π σ²).
    const double off = found[c] - expected[c], noise = deviation[c];
    error += std::sqrt(std::max(0.0, off * off - kNormalMean * noise * noise));
    bias_ += off;
  }
  errors_.push_back(error);
  values_.push_back(Sum(expected));
}

Result<Comparison> ErrorTally::Finish() const {
  const auto n = static_cast<double>(values_.size());
  const double mean = std::accumulate(values_.begin(), values_.end(), 0.0) / n;
  if (!(mean > 0)) {
    return Error(StatusCode::kInvalidArgument, "what is compared with has no irradiance");
  }
  Comparison result;
  result.samples = values_.size();
  result.unmatched = unmatched_;
  std::vector<double> local(errors_.size());
  double sum = 0, squares = 0, largest = 0;
  for (size_t i = 0; i < errors_.size(); ++i) {
    sum += errors_[i];
    squares += errors_[i] * errors_[i];
    largest = std::max(largest, errors_[i]);
    local[i] = errors_[i] / std::max(values_[i], kDarkShare * mean);
  }
  result.l1_relative = sum / n / mean;
  result.rms_relative = std::sqrt(squares / n) / mean;
  result.max_relative = largest / mean;
  result.bias_relative = bias_ / n / mean;
  const auto place = local.begin() + static_cast<std::ptrdiff_t>(0.95 * n);
  std::nth_element(local.begin(), place, local.end());
  result.p95_local = *place;
  return result;
}

Result<Comparison> Compare(const PatchFile& a, const PatchFile& b,
                           const ComparisonOptions& options) {
  ErrorTally tally;
  RETURN_IF_ERROR(Sample(a, b, options, [&](const auto& in_a, const auto& in_b, const Vec3& point) {
    tally.Add(in_a ? IrradianceAt(a, *in_a, point) : Rgb(0.0),
              in_b ? IrradianceAt(b, *in_b, point) : Rgb(0.0));
    if (!in_a || !in_b) tally.AddUnmatched();
  }));
  return tally.Finish();
}

bool HaveSameBands(const PatchFile& a, const PatchFile& b) {
  return !a.bands.empty() && a.bands == b.bands;
}

Result<BandsComparison> CompareBands(const PatchFile& a, const PatchFile& b,
                                     const ComparisonOptions& options) {
  const size_t count = b.bands.size();
  struct Sums {
    double error = 0, square = 0, largest = 0, expected = 0;
  };
  std::vector<Sums> sums(count);
  const std::vector<double> dark(count, 0.0);
  RETURN_IF_ERROR(Sample(a, b, options, [&](const auto& in_a, const auto& in_b, const Vec3& point) {
    const std::vector<double> found = in_a ? BandIrradianceAt(a, *in_a, point) : dark;
    const std::vector<double> expected = in_b ? BandIrradianceAt(b, *in_b, point) : dark;
    for (size_t band = 0; band < count; ++band) {
      const double error = std::abs(found[band] - expected[band]);
      sums[band].error += error;
      sums[band].square += error * error;
      sums[band].largest = std::max(sums[band].largest, error);
      sums[band].expected += expected[band];
    }
  }));
  const auto n = static_cast<double>(options.samples);
  BandsComparison result;
  double error = 0, expected = 0;
  for (const Sums& of_band : sums) {
    error += of_band.error;
    expected += of_band.expected;
    BandComparison& band = result.bands.emplace_back();
    band.dark = !(of_band.expected > 0);
    if (band.dark) continue;
    band.l1_relative = of_band.error / of_band.expected;
    band.rms_relative = std::sqrt(of_band.square * n) / of_band.expected;
    band.max_relative = of_band.largest * n / of_band.expected;
  }
  if (!(expected > 0)) {
    return Error(StatusCode::kInvalidArgument, "what is compared with has no light in any band");
  }
  result.l1_relative = error / expected;
  return result;
}

Result<Comparison> Compare(const PatchFile& file, std::span<const ReferencePoint> points) {
  const PatchLocator locator(file);
  ErrorTally tally;
  for (const ReferencePoint& point : points) {
    const auto face = locator.FindAlong(point.normal, point.position);
    tally.Add(face ? IrradianceAt(file, *face, point.position) : Rgb(0.0), point.irradiance,
              point.deviation);
    if (!face) tally.AddUnmatched();
  }
  return tally.Finish();
}

}  // namespace isolux
