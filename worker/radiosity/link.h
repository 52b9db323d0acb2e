// A link couples two nodes, in both directions by one number, so the matrix is symmetric to the
// last bit. 24 bytes: what the product needs, and what judging the link again in a later round
// needs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace isolux {

struct Link {
  static constexpr uint8_t kProved = 255;  // visible_rays of a link known to be free of obstacles
  static constexpr int kRays = 8;          // a link is sampled by one packet

  uint32_t p = 0, q = 0;    // indices into the tree; the id of p is less than that of q
  float unoccluded_m2 = 0;  // C_pq as if nothing stood between
  float variation_p = 0;  // range of F(x→q) over p; of a cluster's link: the upper bound of C, m²
  float variation_q = 0;       // range of F(y→p) over q; of a cluster's link: 0
  uint16_t visible_share = 0;  // of the unoccluded coupling, in 1/65535
  uint8_t visible_rays = 0;    // of kRays, or kProved; through mirrors: see rays()
  uint8_t error_code = 0;      // error of unoccluded_m2 is unoccluded_m2 · (error_code/255)²

  // A link through mirrors: `image` is the number of the image of q that p sees. Its share is in
  // 1/255, and its coupling counts as exact. A link of a node with itself stands for half of what
  // it exchanges, since it is counted at both ends.
  static constexpr uint8_t kMirrored = 0x40;
  void SetThroughMirrors(uint32_t image, double share, int rays) {
    const auto in_255 = static_cast<uint32_t>(std::lround(255 * share));
    visible_share = static_cast<uint16_t>(in_255 << 8 | (image >> 8 & 0xff));
    error_code = static_cast<uint8_t>(image & 0xff);
    visible_rays = static_cast<uint8_t>(kMirrored | (rays & (kMirrored - 1)));
  }
  bool through_mirrors() const { return (visible_rays & 0xc0) == kMirrored; }
  uint32_t image() const { return (visible_share & 0xffU) << 8 | error_code; }

  // Of kRays, or kProved.
  int rays() const {
    if (!through_mirrors()) return visible_rays;
    const int count = visible_rays & (kMirrored - 1);
    return count == kMirrored - 1 ? kProved : count;
  }
  double visibility() const {
    return through_mirrors() ? (visible_share >> 8) * (1.0 / 255.0)
                             : visible_share * (1.0 / 65535.0);
  }
  double coupling_m2() const { return static_cast<double>(unoccluded_m2) * visibility(); }
  double coupling_error_m2() const {
    if (through_mirrors()) return 0;
    const double root = error_code * (1.0 / 255.0);
    return unoccluded_m2 * root * root;
  }
  // Standard deviation of what one ray through this link sees, with the uncertainty of eight rays
  // that agree: √(v(1−v)), v = (k+1)/(n+2).
  double visibility_deviation() const {
    if (rays() == kProved) return 0;
    const double v = (rays() + 1.0) / (kRays + 2.0);
    return std::sqrt(v * (1 - v));
  }
  // By which rays at output points are shared out. Links whose eight rays agree are right but for a
  // few, and would otherwise take most of all rays.
  double doubt() const {
    constexpr double kUnanimous = 0.3;
    const bool unanimous = rays() == 0 || rays() == kRays;
    return visibility_deviation() * (unanimous ? kUnanimous : 1.0);
  }
};
static_assert(sizeof(Link) == 24);

// Rounded up. Only operations that every processor rounds alike.
inline uint8_t EncodeCouplingError(double error_m2, double coupling_m2) {
  if (!(error_m2 > 0) || !(coupling_m2 > 0)) return 0;
  return static_cast<uint8_t>(std::ceil(255 * std::sqrt(std::min(1.0, error_m2 / coupling_m2))));
}

}  // namespace isolux
