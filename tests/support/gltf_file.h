// glTF files made in code: buffers filled value by value, the rest as JSON, written as text with a
// data URI, as text with a file beside it, or as a binary file.
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/vec.h"

namespace isolux::testing {

inline std::string Base64(const std::string& bytes) {
  const char code[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) {
      word = word << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0U);
    }
    for (size_t k = 0; k < 4; ++k) {
      const bool padding = i + k > bytes.size();
      text += padding ? '=' : code[word >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

class GltfFile {
 public:
  using Json = nlohmann::json;

  Json json{{"asset", {{"version", "2.0"}}}};
  std::string buffer;

  // A view of its own of these values; returns its number.
  template <typename T>
  int View(const std::vector<T>& values) {
    while (buffer.size() % 4 != 0) buffer += '\0';
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", values.size() * sizeof(T)}});
    buffer.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return Last("bufferViews");
  }
  template <typename T>
  int Accessor(const std::vector<T>& values, int components, bool normalized = false) {
    const char* types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    json["accessors"].push_back({{"bufferView", View(values)},
                                 {"componentType", TypeOf(T())},
                                 {"count", values.size() / static_cast<size_t>(components)},
                                 {"type", types[components - 1]}});
    if (normalized) json["accessors"].back()["normalized"] = true;
    return Last("accessors");
  }
  int Points(const std::vector<Vec3>& points) {
    std::vector<float> values;
    for (const Vec3& p : points) {
      for (int i = 0; i < 3; ++i) values.push_back(static_cast<float>(p[i]));
    }
    return Accessor(values, 3);
  }
  int Material(const Json& material) {
    json["materials"].push_back(material);
    return Last("materials");
  }
  // A mesh of one primitive; `indices` and `material` may be −1.
  int Mesh(int positions, int indices = -1, int material = -1, int mode = 4) {
    Json primitive{{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
    if (indices >= 0) primitive["indices"] = indices;
    if (material >= 0) primitive["material"] = material;
    json["meshes"].push_back({{"primitives", Json::array({primitive})}});
    return Last("meshes");
  }
  // A root of the scene unless `root` is false.
  int Node(const Json& node, bool root = true) {
    json["nodes"].push_back(node);
    if (root) json["scenes"][0]["nodes"].push_back(Last("nodes"));
    return Last("nodes");
  }
  // A square of side 2 about the centre, seen counter-clockwise from +z, at height z.
  int Square(int material, double z = 0) {
    const int positions = Points({{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}});
    return Mesh(positions, Accessor(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, 1), material);
  }

  // With the buffer as a data URI, or at `uri`.
  std::string Text(const std::string& uri = "") const {
    Json all = json;
    if (!buffer.empty()) {
      const std::string data = "data:application/octet-stream;base64," + Base64(buffer);
      all["buffers"] =
          Json::array({{{"byteLength", buffer.size()}, {"uri", uri.empty() ? data : uri}}});
    }
    return all.dump();
  }
  std::string Binary() const {
    Json all = json;
    all["buffers"] = Json::array({{{"byteLength", buffer.size()}}});
    std::string text = all.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string data = buffer;
    data.resize((data.size() + 3) / 4 * 4, '\0');
    const auto word = [](uint64_t value) {
      std::string bytes;
      for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
      return bytes;
    };
    return "glTF" + word(2) + word(28 + text.size() + data.size()) + word(text.size()) + "JSON" +
           text + word(data.size()) + std::string("BIN\0", 4) + data;
  }

 private:
  int Last(const char* list) const { return static_cast<int>(json[list].size()) - 1; }
  static int TypeOf(int8_t) { return 5120; }
  static int TypeOf(uint8_t) { return 5121; }
  static int TypeOf(int16_t) { return 5122; }
  static int TypeOf(uint16_t) { return 5123; }
  static int TypeOf(uint32_t) { return 5125; }
  static int TypeOf(float) { return 5126; }
};

}  // namespace isolux::testing
