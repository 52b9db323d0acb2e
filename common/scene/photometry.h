// Luminous intensity of a luminaire by direction, as measured (LM-63 files, type C): a table over
// angles from its axis and around it, bilinear in between.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/bytes.h"
#include "common/util/status.h"
#include "common/vec.h"

namespace isolux {

struct Photometry {
  static constexpr uint32_t kMostAngles = 3'601;

  std::string name;  // of the file
  // Degrees, ascending: from the axis, within [0, 180]; around it, from 0 to 0, 90, 180 or 360 (the
  // rest by symmetry).
  std::vector<float> from_axis, around;
  std::vector<float> intensity;  // cd (or W/sr): all angles from the axis for each around it

  bool operator==(const Photometry&) const = default;

  // In a direction of length 1, for an axis and a direction across it where angles around begin,
  // orthogonal and of length 1. Nothing beyond the first and last angle from the axis.
  double Towards(const Vec3& direction, const Vec3& axis, const Vec3& ahead) const;
  // Largest of the table.
  double Largest() const;
  // In all directions, lm (or W): exact for the interpolated table.
  double Power() const;
};

// Whether angles ascend, cover what they must, and intensities are in range.
Status CheckPhotometry(const Photometry& photometry);

// As part of an encoded scene. What is not there has too few numbers, or the reader fails.
void Put(ByteWriter& out, const Photometry& photometry);
Photometry GetPhotometry(ByteReader& in);

}  // namespace isolux
