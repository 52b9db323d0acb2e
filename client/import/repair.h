// What the importer mends: from the faces of a file to triangles and convex planar quads that the
// solver takes, with a count and an example of everything that was not as it should be.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/import/import.h"
#include "client/import/scene_file.h"

namespace isolux {

// In the order of the report. The text of each stands in repair.cc.
enum class Repair {
  kWelded,
  kZeroArea,
  kDuplicate,
  kTwin,
  kTwinOtherMaterial,
  kNonPlanar,
  kSelfCrossing,
  kDivided,
  kMerged,
  kRegion,
  kContact,
  kPenetration,
  kCovered,
  kTJunction,
  kSmallContact,
  kPieceLimit,
  kReflectance,
  kMaterialless,
  kNoLibrary,
  kRepeatedMaterial,
  kMap,
  kCoordinates,
  kNoMap,
  kEmissionMap,
  kOpacityMap,
  kMirror,
  kMirrorColour,
  kMirrorShare,
  kGlossy,
  kGlass,
  kSheetShare,
  kSheetMap,
  kGlassShare,
  kUnlit,
  kLines,
  kAnimated,
  kCamera,
};

const char* ToText(Repair kind);

// Counts, each with the first place where it happened.
class RepairLog {
 public:
  // `where` is made up by the caller only for the first of a kind.
  template <typename MakeWhere>
  void Add(Repair kind, const MakeWhere& where) {
    Add(kind, 1, where);
  }
  template <typename MakeWhere>
  void Add(Repair kind, uint64_t count, const MakeWhere& where) {
    Entry& entry = entries_[static_cast<size_t>(kind)];
    if (entry.count == 0 && count > 0) entry.example = where();
    entry.count += count;
  }

  RepairReport Report() const;
  // With --strict: an error for the first kind that mends a defect. Dividing, merging, replacing
  // maps by their mean and the like are no defects.
  Status CheckStrict() const;

 private:
  struct Entry {
    uint64_t count = 0;
    std::string example;
  };
  static constexpr size_t kKinds = static_cast<size_t>(Repair::kCamera) + 1;
  std::array<Entry, kKinds> entries_;
};

// The vertices and polygons of `scene` from the faces of `file`. On entry the scene has its unit
// and its materials, one for each of the file's and a last one for faces without. `glasses`: one
// for each of the file's materials (glass.h).
Status BuildPolygons(const SceneFile& file, const std::vector<Glass>& glasses,
                     const ImportOptions& options, Scene* scene, RepairLog* log);

}  // namespace isolux
