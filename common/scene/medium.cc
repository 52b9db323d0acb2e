#include "common/scene/medium.h"

#include <cmath>

namespace isolux {

// Reduced by powers of two to |r| ≤ ln 2/2, then Taylor's series to the fourteenth power.
double ExpOfMinus(double x) {
  if (!(x < 700)) return 0;
  const double k = std::round(x * 1.44269504088896338700);
  const double r = k * 6.93147180369123816490e-01 - x + k * 1.90821492927058770002e-10;
  double sum = 1;
  for (int n = 14; n > 0; --n) sum = 1 + sum * r / n;
  return std::ldexp(sum, -static_cast<int>(k));
}

Rgb Medium::Along(double metres) const {
  const double first = ExpOfMinus(extinction_per_m.x * metres);
  if (is_grey()) return Rgb(first);
  return {first, ExpOfMinus(extinction_per_m.y * metres), ExpOfMinus(extinction_per_m.z * metres)};
}

Status CheckMedium(const Medium& medium) {
  for (int c = 0; c < 3; ++c) {
    const double extinction = medium.extinction_per_m[c];
    if (!(extinction >= 0 && extinction <= kLargestExtinction)) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "the medium's extinction of {} per metre is not from 0 to {:g}; is the "
                        "unit right?",
                        extinction, kLargestExtinction);
    }
  }
  return {};
}

}  // namespace isolux
