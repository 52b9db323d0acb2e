#include "server/output_maps.h"

namespace isolux {
namespace {

constexpr double kContrast = 0.1;
constexpr int kDivisions = 3;

// Deviation of the radiosity over an element that its maps make, over the mean.
double MapContrast(const Hierarchy& hierarchy, const Surface& surface, const Field& element) {
  const Optics optics = hierarchy.maps().Over(surface, element.shape);
  double mean = 0, deviation = 0;
  for (int c = 0; c < 3; ++c) {
    double irradiance = 0;
    for (int k = 0; k < element.shape.count; ++k) {
      irradiance += static_cast<double>(element.value[k][c]) / element.shape.count;
    }
    mean += optics.exitance[c] + optics.reflectance[c] * irradiance;
    deviation += optics.exitance_deviation[c] + optics.reflectance_deviation[c] * irradiance;
  }
  return mean > 0 ? deviation / mean : 0;
}

void DivideOnce(const Hierarchy& hierarchy, uint64_t max_elements,
                std::vector<OutputElement>* elements) {
  std::vector<OutputElement> made;
  for (size_t i = 0; i < elements->size(); ++i) {
    const OutputElement& element = (*elements)[i];
    const Surface& surface = hierarchy.surfaces()[element.id.surface];
    const Field whole{ElementGeometry(hierarchy.geometry(element.id.surface), element.id.path),
                      element.irradiance};
    const uint64_t count = elements->size() - i + made.size() + 3;
    if (count > max_elements || element.id.level() + 2 > kMaxLevel ||
        MapContrast(hierarchy, surface, whole) <= kContrast) {
      made.push_back(element);
      continue;
    }
    const std::array<Field, 2> halves = Cut(whole);
    for (int h = 0; h < 2; ++h) {
      const std::array<Field, 2> quarters = Cut(halves[h]);
      for (int q = 0; q < 2; ++q) {
        made.push_back({element.id.Child(h).Child(q), element.leaf, quarters[q].value});
      }
    }
  }
  *elements = std::move(made);
}

}  // namespace

void DivideByMaps(const Hierarchy& hierarchy, uint64_t max_elements,
                  std::vector<OutputElement>* elements) {
  if (hierarchy.scene().textures.empty()) return;
  for (int k = 0; k < kDivisions; ++k) DivideOnce(hierarchy, max_elements, elements);
}

}  // namespace isolux
