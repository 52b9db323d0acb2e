#include "client/import/gltf_nodes.h"

#include <cmath>
#include <span>

#include "common/vec.h"

namespace isolux {
namespace {

constexpr int kDeepest = 512;
constexpr double kAffine = 1e-6;  // of the last row of a matrix, which files print in full

bool AllFinite(const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      if (!std::isfinite(m[c][r])) return false;
    }
  }
  return true;
}

// Rotation by a quaternion (x, y, z, w), which need not be of unit length.
glm::dmat4 Rotation(const std::vector<double>& q) {
  const double s = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {{1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w), 0},
          {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w), 0},
          {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y), 0},
          {0, 0, 0, 1}};
}

class Walker {
 public:
  explicit Walker(const GltfDocument& document)
      : document_(document), model_(document.model), reached_(model_.nodes.size(), false) {}

  Result<GltfNodes> Run();

 private:
  struct Step {
    int node = 0;
    int depth = 0;
    glm::dmat4 parent{1.0};
  };

  Result<std::vector<int>> Roots() const;
  Status Visit(const Step& step);
  Result<glm::dmat4> TransformOf(const tinygltf::Node& node, const std::string& where) const;
  std::string Where(int node) const {
    const std::string& name = model_.nodes[node].name;
    return name.empty() ? fmt::format("nodes[{}]", node)
                        : fmt::format("nodes[{}] '{}'", node, name);
  }

  const GltfDocument& document_;
  const tinygltf::Model& model_;
  std::vector<bool> reached_;
  std::vector<Step> steps_;  // still to be taken, the next one last
  GltfNodes found_;
};

Result<std::vector<int>> Walker::Roots() const {
  if (!model_.scenes.empty()) {
    const int scene = std::max(model_.defaultScene, 0);
    if (static_cast<size_t>(scene) < model_.scenes.size()) return model_.scenes[scene].nodes;
    return document_.Error(StatusCode::kInvalidArgument, "scene",
                           "scenes[{}] does not exist, the file has {}; correct it", scene,
                           model_.scenes.size());
  }
  std::vector<bool> is_child(model_.nodes.size(), false);
  for (const tinygltf::Node& node : model_.nodes) {
    for (const int child : node.children) {
      if (child >= 0 && static_cast<size_t>(child) < is_child.size()) is_child[child] = true;
    }
  }
  std::vector<int> roots;
  for (size_t n = 0; n < is_child.size(); ++n) {
    if (!is_child[n]) roots.push_back(static_cast<int>(n));
  }
  return roots;
}

Result<glm::dmat4> Walker::TransformOf(const tinygltf::Node& node, const std::string& where) const {
  const auto check = [&](const std::vector<double>& numbers, size_t count) {
    return numbers.empty() || numbers.size() == count;
  };
  glm::dmat4 m(1.0);
  bool good = check(node.matrix, 16) && check(node.translation, 3) && check(node.rotation, 4) &&
              check(node.scale, 3);
  if (good && !node.matrix.empty()) {
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[i];
    const glm::dvec4 last(m[0][3], m[1][3], m[2][3], m[3][3] - 1);
    good = glm::length(last) <= kAffine;
    for (int c = 0; c < 4; ++c) m[c][3] = c == 3 ? 1.0 : 0.0;
  } else if (good) {
    if (!node.rotation.empty()) m = Rotation(node.rotation);
    if (!node.scale.empty()) {
      for (int c = 0; c < 3; ++c) m[c] *= node.scale[c];
    }
    if (!node.translation.empty()) {
      m[3] = {node.translation[0], node.translation[1], node.translation[2], 1};
    }
  }
  if (good && AllFinite(m)) return m;
  return document_.Error(StatusCode::kInvalidArgument, where,
                         "matrix, translation, rotation or scale is not an affine map of finite "
                         "numbers; correct it");
}

Status Walker::Visit(const Step& step) {
  const auto fail = [&](const std::string& where, const char* what) {
    return document_.Error(StatusCode::kInvalidArgument, where, "{}", what);
  };
  if (step.node < 0 || static_cast<size_t>(step.node) >= model_.nodes.size()) {
    return fail(fmt::format("nodes[{}]", step.node),
                "no such node, though the scene or a node names it; is the file whole?");
  }
  const std::string where = Where(step.node);
  if (reached_[step.node]) {
    return fail(where,
                "reached twice: it has two parents or stands below itself; give each parent "
                "a copy");
  }
  if (step.depth > kDeepest) {
    return fail(where, "deeper than 512 nodes; flatten the hierarchy");
  }
  reached_[step.node] = true;
  const tinygltf::Node& node = model_.nodes[step.node];
  ASSIGN_OR_RETURN(const glm::dmat4 own, TransformOf(node, where));
  const glm::dmat4 to_scene = step.parent * own;
  if (!AllFinite(to_scene)) return fail(where, "its transform overflows; correct the scales");
  if (node.mesh >= 0) found_.meshes.push_back({node.mesh, to_scene, where});
  if (node.camera >= 0) {
    found_.cameras.push_back({node.camera, to_scene, where, node.name});
  }
  if (node.skin >= 0) found_.skins.push_back(where);
  if (const auto light = node.extensions.find("KHR_lights_punctual");
      light != node.extensions.end()) {
    const tinygltf::Value& number = light->second.Get("light");
    found_.lights.push_back({number.IsInt() ? number.Get<int>() : -1, to_scene, where});
  }
  for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
    steps_.push_back({*child, step.depth + 1, to_scene});
  }
  return {};
}

Result<GltfNodes> Walker::Run() {
  ASSIGN_OR_RETURN(const std::vector<int> roots, Roots());
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) steps_.push_back({*root, 1});
  while (!steps_.empty()) {
    const Step step = steps_.back();
    steps_.pop_back();
    RETURN_IF_ERROR(Visit(step));
  }
  return std::move(found_);
}

}  // namespace

Result<GltfNodes> WalkNodes(const GltfDocument& document) { return Walker(document).Run(); }

}  // namespace isolux
