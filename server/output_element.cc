#include "server/output_element.h"

#include "common/hierarchy/translucent_sheets.h"

namespace isolux {
namespace {

Channels Mean(const Channels& a, const Channels& b) {
  return {0.5F * (a[0] + b[0]), 0.5F * (a[1] + b[1]), 0.5F * (a[2] + b[2])};
}

// Seen from the other side: values as corners (FromBehind, element.h).
Field FromBehind(const Field& field) {
  Field result{isolux::FromBehind(field.shape), field.value};
  for (int k = 0; k < field.shape.count; ++k) {
    result.value[k] = field.value[CornerBehind(field.shape.count, k)];
  }
  return result;
}

}  // namespace

std::array<Field, 2> Cut(const Field& field) {
  if (field.shape.divided_from_behind) {
    const std::array<Field, 2> halves = Cut(FromBehind(field));
    return {FromBehind(halves[0]), FromBehind(halves[1])};
  }
  const std::array<ConvexPolygon, 2> shapes = Subdivide(field.shape);
  const int n = field.shape.count, i = LongestSide(field.shape);
  const auto value = [&](int k) -> const Channels& { return field.value[(i + k) % n]; };
  const Channels cut = Mean(value(0), value(1));
  if (n == 3) {
    return {Field{shapes[0], {value(0), cut, value(2)}},
            Field{shapes[1], {cut, value(1), value(2)}}};
  }
  const Channels opposite = Mean(value(2), value(3));
  return {Field{shapes[0], {value(0), cut, opposite, value(3)}},
          Field{shapes[1], {cut, value(1), value(2), opposite}}};
}

}  // namespace isolux
