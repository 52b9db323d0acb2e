// The parts of the contour integral: closed forms against numeric integration, and the bounds of
// errors against errors.
#include "worker/coupling/edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/random.h"
#include "tests/support/polygons.h"
#include "tests/worker/coupling/random_pairs.h"

namespace isolux {
namespace {

constexpr double kPi = std::numbers::pi;

// On [from, to], by four points on each of many pieces that get shorter towards both ends.
template <typename Function>
double Numeric(double from, double to, const Function& f) {
  const GaussRule& rule = kGauss[2];
  const auto piece = [&](double a, double b) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += rule.weight[k] * f(a + (b - a) * rule.point[k]);
    return (b - a) * sum;
  };
  const double middle = 0.5 * (from + to);
  double sum = 0;
  for (const double end : {from, to}) {
    double far = middle;
    for (int level = 0; level < 60; ++level) {
      const double near = end + 0.7 * (far - end);
      sum += end == from ? piece(near, far) : piece(far, near);
      far = near;
    }
    sum += end == from ? piece(end, far) : piece(far, end);
  }
  return sum;
}

double PotentialAt(double a, double length, double distance) {
  return Potential(Splat(a), Splat(length), Splat(distance * distance), Splat(0))[0];
}

TEST(Edges, PotentialIsTheIntegralOfTheLogarithm) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double a = 4 * random.Unit() - 2, length = random.Unit();
    const double distance = i % 5 == 0 ? 0 : std::pow(10, -3 * random.Unit());
    const auto log_r = [&](double t) { return std::log(std::hypot(t, distance)); };
    const double cut = std::clamp(0.0, a, a + length);
    EXPECT_NEAR(PotentialAt(a, length, distance),
                Numeric(a, cut, log_r) + Numeric(cut, a + length, log_r) + length, 1e-8)
        << "sample " << i;
  }
}

TEST(Edges, ParallelEdgesMatchNumericIntegration) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const double a = 4 * random.Unit() - 2, length_e = random.Unit(), length_f = random.Unit();
    const double distance = i % 5 == 0 ? 0 : std::pow(10, -3 * random.Unit());
    const double direction = i % 2 == 0 ? 1 : -1;
    const auto potential = [&](double s) {
      return PotentialAt(a - direction * s, length_f, distance);
    };
    // Between the feet of the ends of f.
    double cuts[2] = {direction * a, direction * (a + length_f)};
    std::sort(cuts, cuts + 2);
    double sum = 0, from = 0;
    for (const double cut : {cuts[0], cuts[1], length_e}) {
      const double to = std::clamp(cut, from, length_e);
      sum += Numeric(from, to, potential);
      from = to;
    }
    EXPECT_NEAR(ParallelEdges(a, distance, length_e, length_f, direction), sum, 1e-9)
        << "sample " << i;
  }
}

TEST(Edges, LineDistanceMatchesNumericIntegration) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double from = 4 * random.Unit() - 3, to = from + 2 * random.Unit();
    const double alpha = i % 5 == 0 ? 0 : std::pow(10, -6 * random.Unit());
    const double sine = 0.01 + 0.99 * random.Unit();
    const auto distance = [&](double s) { return std::sqrt(alpha + sine * sine * s * s); };
    const double cut = std::clamp(0.0, from, to);
    EXPECT_NEAR(LineDistance(Splat(sine * from), Splat(sine * to), Splat(alpha), Splat(sine))[0],
                Numeric(from, cut, distance) + Numeric(cut, to, distance), 1e-9)
        << "sample " << i;
  }
}

// Error of a rule on [−half, half].
template <typename Function>
double RuleError(int points, double half, const Function& f) {
  const GaussRule& rule = kGauss[points - 2];
  double sum = 0;
  for (int k = 0; k < points; ++k) sum += rule.weight[k] * f((2 * rule.point[k] - 1) * half);
  return std::abs(2 * half * sum - Numeric(-half, 0, f) - Numeric(0, half, f));
}

TEST(Edges, ExpansionBoundIsABound) {
  Random random(4);
  double tightest = 0;
  for (int i = 0; i < 5000; ++i) {
    // A edge f somewhere around a piece along x, and how near it comes to the piece's centre.
    const double half = 1;
    const Vec3 start = (1.25 + 4 * random.Unit()) * testing::RandomDirection(random);
    const Vec3 along = testing::RandomDirection(random);
    const double length = std::pow(10, 2 * random.Unit() - 1);
    const auto at = [&](double s) { return Vec3(s, 0, 0); };
    const auto potential = [&](double s) {
      const Vec3 to = start - at(s);
      return PotentialAt(glm::dot(to, along), length, glm::length(glm::cross(to, along)));
    };
    const double t = std::clamp(-glm::dot(start, along), 0.0, length);
    const double reach = glm::length(start + t * along);
    if (reach < 1.25) continue;
    for (int points = 2; points <= 4; ++points) {
      const double bound = ExpansionBound(points, Splat(half), Splat(half * half / (reach * reach)),
                                          Splat(std::min(length, kLineShare * reach)))[0];
      const double error = RuleError(points, half, potential);
      EXPECT_LE(error, bound + 1e-11) << points << " points, sample " << i;
      tightest = std::max(tightest, error / bound);
    }
  }
  EXPECT_GT(tightest, 0.1);  // and not an idle one
}

TEST(Edges, BoundsOfTheDistanceFromALineHold) {
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const double half = 1;
    const double nearest = 6 * random.Unit() - 3, sine = random.Unit();
    const double alpha = std::pow(10, 4 * random.Unit() - 3) * sine * sine;
    const auto distance = [&](double s) {
      return std::sqrt(alpha + sine * sine * (s - nearest) * (s - nearest));
    };
    const double at_centre = distance(0);
    const double ratio2 = half * half * sine * sine / (at_centre * at_centre);
    const double bound =
        ExpansionBound(4, Splat(half), Splat(ratio2), Splat(kLineShare * at_centre))[0];
    // The kink itself may be inside: then Numeric needs a cut there.
    const GaussRule& rule = kGauss[2];
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += rule.weight[k] * distance((2 * rule.point[k] - 1) * half);
    const double cut = std::clamp(nearest, -half, half);
    const double error = kPi * std::abs(2 * half * sum - Numeric(-half, cut, distance) -
                                        Numeric(cut, half, distance));
    EXPECT_LE(error, kPi * bound + 1e-10) << "sample " << i;
    EXPECT_LE(error, kKink * sine * half * half + 1e-10) << "sample " << i;
  }
}

}  // namespace
}  // namespace isolux
