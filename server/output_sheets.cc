#include "server/output_sheets.h"

#include <algorithm>

namespace isolux {
namespace {

// The first element at or after an id, in the order of a walk.
std::vector<OutputElement>::const_iterator LowerBound(const std::vector<OutputElement>& elements,
                                                      const NodeId& id) {
  return std::lower_bound(
      elements.begin(), elements.end(), id,
      [](const OutputElement& element, const NodeId& key) { return element.id < key; });
}

class Divider {
 public:
  Divider(const TranslucentSheets& sheets, const std::vector<OutputElement>& elements)
      : sheets_(sheets), elements_(elements) {}

  void Divide(const OutputElement& element, const ConvexPolygon& shape) {
    const NodeId behind = sheets_.PartnerOf(element.id);
    const auto at = LowerBound(elements_, behind);
    const bool finer = at != elements_.end() && at->id != behind && Contains(behind, at->id);
    if (!finer) {
      made_.push_back(element);
      return;
    }
    const std::array<Field, 2> halves = Cut({shape, element.irradiance});
    for (int h = 0; h < 2; ++h) {
      Divide({element.id.Child(h), element.leaf, halves[h].value}, halves[h].shape);
    }
  }
  void Keep(const OutputElement& element) { made_.push_back(element); }
  std::vector<OutputElement> Take() { return std::move(made_); }

 private:
  const TranslucentSheets& sheets_;
  const std::vector<OutputElement>& elements_;
  std::vector<OutputElement> made_;
};

}  // namespace

void DivideSheetsAlike(const Hierarchy& hierarchy, const TranslucentSheets& sheets,
                       std::vector<OutputElement>* elements) {
  if (sheets.empty()) return;
  Divider divider(sheets, *elements);
  for (const OutputElement& element : *elements) {
    if (sheets.PartnerOf(element.id.surface) == TranslucentSheets::kNone) {
      divider.Keep(element);
    } else {
      divider.Divide(element,
                     ElementGeometry(hierarchy.geometry(element.id.surface), element.id.path));
    }
  }
  *elements = divider.Take();
}

std::vector<uint32_t> ElementsBehind(const TranslucentSheets& sheets,
                                     const std::vector<OutputElement>& elements) {
  std::vector<uint32_t> behind;
  if (sheets.empty()) return behind;
  behind.assign(elements.size(), TranslucentSheets::kNone);
  for (size_t e = 0; e < elements.size(); ++e) {
    if (sheets.PartnerOf(elements[e].id.surface) == TranslucentSheets::kNone) continue;
    const NodeId wanted = sheets.PartnerOf(elements[e].id);
    const auto at = LowerBound(elements, wanted);
    if (at == elements.end() || at->id != wanted) continue;
    behind[e] = static_cast<uint32_t>(at - elements.begin());
  }
  return behind;
}

}  // namespace isolux
