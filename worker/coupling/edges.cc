#include "worker/coupling/edges.h"

namespace isolux {

Edges::Edges(std::span<const Vec3> corners) {
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 d = corners[(i + 1) % corners.size()] - corners[i];
    const double length = glm::length(d);
    if (length > 0) edge[count++] = {corners[i], d / length, length};
    perimeter += length;
  }
}

// The antiderivative of g over u is [u g + α asinh(u/√α)]/2, odd in u.
Lanes LineDistance(Lanes from, Lanes to, Lanes alpha, Lanes sine) {
  const Lanes tiny = Splat(1e-300);
  const Lanes log_root = 0.5 * Log(Maximum(alpha, tiny));
  const auto half_sum = [&](Lanes u) {
    const Lanes size = Absolute(u);
    const Lanes g = SquareRoot(alpha + u * u);
    const Lanes value = size * g + alpha * (Log(Maximum(size + g, tiny)) - log_root);
    return Select(u < 0.0, -value, value);
  };
  return 0.5 * (half_sum(to) - half_sum(from)) / sine;
}

// The second antiderivative of ln√(x² + g²) is (x² − g²)/4 ln(x² + g²) + g |x| atan(|x|/g) − 3/4
// x²; its differences over both lengths.
double ParallelEdges(double a, double distance, double length_e, double length_f,
                     double direction) {
  const double b = a + length_f, step = direction * length_e;
  const Lanes x{b, b - step, a, a - step};
  const Lanes x2 = x * x;
  const Lanes size = Absolute(x);
  const double distance2 = distance * distance;
  const Lanes value = 0.25 * (x2 - distance2) * Log(Maximum(x2 + distance2, Splat(1e-300))) +
                      distance * size * Atan2Upper(size, Splat(distance));
  return direction * ((value[0] - value[1]) - (value[2] - value[3])) - 0.5 * length_e * length_f;
}

}  // namespace isolux
