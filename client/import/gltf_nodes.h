// The node tree of a glTF scene, flattened: which meshes and lights stand where.
#pragma once

#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "client/import/gltf_document.h"

namespace isolux {

struct GltfInstance {
  int mesh = 0;              // in the document, not checked
  glm::dmat4 to_scene{1.0};  // from the mesh's coordinates; affine, finite
  std::string where;         // "nodes[3] 'lamp'"
};

// A light of KHR_lights_punctual at a node.
struct GltfLightInstance {
  int light = 0;  // in the document, not checked
  glm::dmat4 to_scene{1.0};
  std::string where;
};

struct GltfCameraInstance {
  int camera = 0;  // in the document, not checked
  glm::dmat4 to_scene{1.0};
  std::string where;
  std::string name;  // of the node
};

struct GltfNodes {
  std::vector<GltfInstance> meshes;         // in the order of the tree, parents first
  std::vector<GltfLightInstance> lights;    // likewise
  std::vector<GltfCameraInstance> cameras;  // likewise
  std::vector<std::string> skins;           // of nodes of the scene, where ("nodes[3]")
};

// Of the document's scene, else the first one, else of all nodes without parents. A node that is
// reached twice is refused: what glTF holds are trees.
Result<GltfNodes> WalkNodes(const GltfDocument& document);

}  // namespace isolux
