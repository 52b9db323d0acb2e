#include "client/import/gltf_reader.h"

#include <map>
#include <numeric>

#include "client/import/gltf_accessors.h"
#include "client/import/gltf_document.h"
#include "client/import/gltf_lights.h"
#include "client/import/gltf_materials.h"
#include "client/import/gltf_nodes.h"

namespace isolux {
namespace {

// The points of an accessor, and which points of the file they have become in one node.
struct Points {
  std::vector<Vec3> values;
  std::vector<uint32_t> number;  // in SceneFile::points
  std::vector<uint32_t> node;    // for which `number` holds: place in the list of nodes, from 1
};

class Reader {
 public:
  Reader(GltfDocument document, const SceneLimits& limits)
      : document_(std::move(document)), limits_(limits) {}

  Result<SceneFile> Read();

 private:
  Status AddInstance(const GltfInstance& instance);
  Status AddPrimitive(const tinygltf::Primitive& primitive, const GltfInstance& instance,
                      const std::string& where);
  Status AddTriangle(const std::array<uint32_t, 3>& corners, const glm::dmat4& to_scene);
  // Makes them current_.
  Status ReadPointsOf(const tinygltf::Primitive& primitive, const std::string& where);
  // Makes current_coordinates_ those of the primitive, where its material has a map.
  Status ReadCoordinatesOf(const tinygltf::Primitive& primitive);
  Result<std::vector<uint32_t>> IndicesOf(const tinygltf::Primitive& primitive) const;

  GltfDocument document_;
  SceneLimits limits_;
  SceneFile file_;
  std::map<int, Points> points_;  // by accessor
  uint64_t point_count_ = 0;      // in points_
  uint64_t triangle_count_ = 0;   // degenerate ones included
  Points* current_ = nullptr;
  // Of coordinates by accessor, where they begin in SceneFile::coordinates, and their number.
  std::map<int, std::pair<uint32_t, uint32_t>> coordinates_;
  std::pair<uint32_t, uint32_t> current_coordinates_;  // none: a number of 0
  uint32_t node_ = 0;
  FileFace face_;  // what the faces of the current primitive have in common
};

Status Reader::ReadPointsOf(const tinygltf::Primitive& primitive, const std::string& where) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) {
    return document_.Error(StatusCode::kInvalidArgument, where,
                           "no attribute POSITION; export the file anew");
  }
  const auto [at, is_new] = points_.try_emplace(position->second);
  current_ = &at->second;
  if (!is_new) return {};
  ASSIGN_OR_RETURN(current_->values,
                   ReadPoints(document_, position->second, limits_.vertices - point_count_));
  point_count_ += current_->values.size();
  current_->number.resize(current_->values.size());
  current_->node.assign(current_->values.size(), 0);
  return {};
}

Status Reader::ReadCoordinatesOf(const tinygltf::Primitive& primitive) {
  current_coordinates_ = {0, 0};
  if (primitive.material < 0) return {};
  const FileMaterial& material = file_.materials[primitive.material];
  if (material.diffuse_map.name.empty() && material.emission_map.name.empty()) return {};
  const auto attribute =
      primitive.attributes.find(fmt::format("TEXCOORD_{}", material.coordinate_set()));
  if (attribute == primitive.attributes.end()) return {};
  const auto [at, is_new] = coordinates_.try_emplace(attribute->second);
  if (is_new) {
    ASSIGN_OR_RETURN(
        const std::vector<glm::dvec2> values,
        ReadCoordinates(document_, attribute->second, limits_.vertices - file_.coordinates.size()));
    at->second = {static_cast<uint32_t>(file_.coordinates.size()),
                  static_cast<uint32_t>(values.size())};
    file_.coordinates.insert(file_.coordinates.end(), values.begin(), values.end());
  }
  current_coordinates_ = at->second;
  return {};
}

Result<std::vector<uint32_t>> Reader::IndicesOf(const tinygltf::Primitive& primitive) const {
  if (primitive.indices >= 0) {
    return ReadIndices(document_, primitive.indices, 3 * limits_.polygons);
  }
  std::vector<uint32_t> indices(current_->values.size());
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

Status Reader::AddTriangle(const std::array<uint32_t, 3>& corners, const glm::dmat4& to_scene) {
  const std::string& where = file_.parts[face_.place];
  if (++triangle_count_ > limits_.polygons) {
    return document_.Error(StatusCode::kResourceExhausted, where,
                           "more than {} triangles so far; simplify the scene", limits_.polygons);
  }
  for (const uint32_t index : corners) {
    if (index < current_->values.size()) continue;
    return document_.Error(StatusCode::kInvalidArgument, where,
                           "index {} names a point that is not there, POSITION has {}; is the file "
                           "whole?",
                           index, current_->values.size());
  }
  FileFace face = face_;
  face.first = file_.corners.size();
  face.count = 3;
  for (const uint32_t index : corners) {
    if (current_->node[index] != node_) {
      if (file_.points.size() >= limits_.vertices) {
        return document_.Error(StatusCode::kResourceExhausted, where,
                               "more than {} vertices so far; simplify the scene",
                               limits_.vertices);
      }
      current_->node[index] = node_;
      current_->number[index] = static_cast<uint32_t>(file_.points.size());
      file_.points.emplace_back(to_scene * glm::dvec4(current_->values[index], 1));
    }
    file_.corners.push_back(current_->number[index]);
    const auto [first, count] = current_coordinates_;
    file_.corner_coordinates.push_back(index < count ? first + index : kNoCoordinates);
  }
  file_.faces.push_back(face);
  return {};
}

Status Reader::AddPrimitive(const tinygltf::Primitive& primitive, const GltfInstance& instance,
                            const std::string& where) {
  if (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    file_.lines.push_back(fmt::format("{}: {}", document_.path, where));
    return {};
  }
  if (primitive.mode < 0 || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return document_.Error(StatusCode::kInvalidArgument, where,
                           "mode {} is not one of 0 to 6; export the file anew", primitive.mode);
  }
  const size_t materials = document_.model.materials.size();
  if (primitive.material >= 0 && static_cast<size_t>(primitive.material) >= materials) {
    return document_.Error(StatusCode::kInvalidArgument, where,
                           "materials[{}] does not exist, the file has {}; is the file whole?",
                           primitive.material, materials);
  }
  if (!primitive.targets.empty()) {
    file_.animated.push_back(fmt::format("{}: {}", document_.path, where));
  }
  RETURN_IF_ERROR(ReadPointsOf(primitive, where));
  RETURN_IF_ERROR(ReadCoordinatesOf(primitive));
  ASSIGN_OR_RETURN(const std::vector<uint32_t> indices, IndicesOf(primitive));
  face_.place = static_cast<uint32_t>(file_.parts.size());
  face_.material = primitive.material < 0 ? kNoMaterial : static_cast<uint32_t>(primitive.material);
  file_.parts.push_back(where);
  const bool list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  const bool fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
  const bool mirrored = glm::determinant(glm::dmat3(instance.to_scene)) < 0;
  for (size_t i = 0; i + 3 <= indices.size(); i += list ? 3 : 1) {
    std::array<uint32_t, 3> corners{indices[fan ? 0 : i], indices[i + 1], indices[i + 2]};
    const bool repeats =
        corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
    if (!list && repeats) {  // how strips jump from one piece to the next
      ++triangle_count_;
      continue;
    }
    const bool odd = !list && !fan && i % 2 == 1;
    if (odd != mirrored) std::swap(corners[1], corners[2]);
    RETURN_IF_ERROR(AddTriangle(corners, instance.to_scene));
  }
  return {};
}

Status Reader::AddInstance(const GltfInstance& instance) {
  const tinygltf::Model& model = document_.model;
  if (static_cast<size_t>(instance.mesh) >= model.meshes.size()) {
    return document_.Error(StatusCode::kInvalidArgument, instance.where,
                           "meshes[{}] does not exist, the file has {}; is the file whole?",
                           instance.mesh, model.meshes.size());
  }
  ++node_;
  const auto& primitives = model.meshes[instance.mesh].primitives;
  for (size_t p = 0; p < primitives.size(); ++p) {
    RETURN_IF_ERROR(AddPrimitive(
        primitives[p], instance,
        fmt::format("{}, meshes[{}].primitives[{}]", instance.where, instance.mesh, p)));
  }
  return {};
}

Result<SceneFile> Reader::Read() {
  file_.path = document_.path;
  ASSIGN_OR_RETURN(file_.materials, ReadGltfMaterials(document_, &file_.images));
  ASSIGN_OR_RETURN(const GltfNodes nodes, WalkNodes(document_));
  const auto note = [&](const std::vector<std::string>& places, std::vector<std::string>* list) {
    for (const std::string& where : places) {
      list->push_back(fmt::format("{}: {}", document_.path, where));
    }
  };
  for (const GltfCameraInstance& camera : nodes.cameras) {
    note({camera.where}, &file_.cameras);
  }
  note(nodes.skins, &file_.animated);
  note(std::vector<std::string>(document_.model.animations.empty() ? 0 : 1, "animations"),
       &file_.animated);
  ASSIGN_OR_RETURN(file_.lights, ReadGltfLights(document_, nodes));
  for (const GltfInstance& instance : nodes.meshes) RETURN_IF_ERROR(AddInstance(instance));
  if (file_.faces.empty()) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: no triangles: no node of the scene has a mesh of them; is the file whole?",
                 file_.path);
  }
  return std::move(file_);
}

}  // namespace

Result<SceneFile> ReadGltf(const std::string& path, const SceneLimits& limits) {
  ASSIGN_OR_RETURN(GltfDocument document, ReadGltfDocument(path));
  return Reader(std::move(document), limits).Read();
}

Result<SceneFile> ParseGltf(const std::string& bytes, const std::string& path,
                            const SceneLimits& limits) {
  ASSIGN_OR_RETURN(GltfDocument document, ParseGltfDocument(bytes, path));
  return Reader(std::move(document), limits).Read();
}

}  // namespace isolux
