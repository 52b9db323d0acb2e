#include "client/import/gltf_document.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostGltfBytes =
    (2ULL << 30) - 1;                             // of the scene file; the parser counts in int
constexpr uint64_t kMostOtherBytes = 4ULL << 30;  // of all files it names
// The parser walks "extras" by recursion, and takes up to 300 bytes a value.
constexpr int kDeepestJson = 64;
constexpr uint64_t kMostJsonValues = 4'000'000;

// Extensions that a file may require: read, or of no effect on diffuse light.
constexpr std::string_view kKnownExtensions[] = {
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_xmp_json_ld",
    "FB_ngon_encoding",
};

// What the parser may read: files of one folder.
struct Folder {
  std::string path;
  uint64_t bytes_left = kMostOtherBytes;
  Status refused;  // the first name that leads out of the folder
  Status failed;   // the last file that could not be read
};

bool ReadInside(std::vector<unsigned char>* out, std::string* error, const std::string& uri,
                void* user_data) {
  Folder& folder = *static_cast<Folder*>(user_data);
  const Result<std::string> path = ResolveInside(folder.path, uri);
  Status status = path.has_value() ? Status() : path.error();
  if (status.code() == StatusCode::kPermissionDenied && folder.refused.ok()) {
    folder.refused = status;
  }
  if (status.ok()) {
    const Result<std::string> bytes = ReadFile(*path, std::min(kMostGltfBytes, folder.bytes_left));
    if (bytes.has_value()) {
      folder.bytes_left -= bytes->size();
      out->assign(bytes->begin(), bytes->end());
      return true;
    }
    status = bytes.error();
  }
  folder.failed = status;
  *error = status.message();
  return false;
}

tinygltf::FsCallbacks CallbacksOf(Folder* folder) {
  tinygltf::FsCallbacks callbacks{};
  // Names stay as the file has them, so that ReadInside judges them.
  callbacks.FileExists = [](const std::string&, void*) { return true; };
  callbacks.ExpandFilePath = [](const std::string& name, void*) { return name; };
  callbacks.ReadWholeFile = ReadInside;
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                                void*) { return false; };
  callbacks.user_data = folder;
  return callbacks;
}

// Images are decoded when a material needs them. The bytes of one in a buffer view are not checked
// by the parser, so they are not touched.
bool KeepEncoded(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                 const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

// Depth and number of values, before any parser sees the text.
Status CheckJson(std::string_view text, const std::string& path) {
  int depth = 0;
  uint64_t values = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') --depth;
    if (c == ',' || c == '{' || c == '[') ++values;
    if (depth > kDeepestJson || values > kMostJsonValues) {
      return MakeStatus(StatusCode::kResourceExhausted,
                        "{}: JSON of more than {} levels or {} values; simplify the scene", path,
                        kDeepestJson, kMostJsonValues);
    }
  }
  return {};
}

uint64_t Word(const std::string& bytes, size_t at) {
  std::array<unsigned char, 4> word;
  std::memcpy(word.data(), bytes.data() + at, 4);
  return word[0] | word[1] << 8 | word[2] << 16 | static_cast<uint64_t>(word[3]) << 24;
}

// The JSON of a binary file whose lengths are consistent.
Result<std::string_view> CheckBinary(const std::string& bytes, const std::string& path) {
  constexpr uint64_t kJsonChunk = 0x4E4F534A;
  const auto fail = [&](const char* what) {
    return Error(StatusCode::kDataLoss, "{}: {}; is the file whole?", path, what);
  };
  if (bytes.size() < 20) return fail("too short for a binary glTF file");
  if (Word(bytes, 4) != 2) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: binary glTF of version {}; export it as glTF 2.0", path, Word(bytes, 4));
  }
  const uint64_t length = Word(bytes, 8);
  const uint64_t json_end = 20 + Word(bytes, 12);
  if (length > bytes.size()) return fail("shorter than its head says");
  if (Word(bytes, 16) != kJsonChunk || json_end > length) return fail("no whole JSON chunk");
  if (json_end < length &&
      (json_end + 8 > length || json_end + 8 + Word(bytes, json_end) > length)) {
    return fail("its binary chunk is longer than the file");
  }
  return std::string_view(bytes).substr(20, json_end - 20);
}

// The parser's messages end lines.
std::string OneLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  constexpr size_t kLongest = 300;
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "…";
  return text.empty() ? "not a glTF document" : text;
}

Status CheckAsset(const tinygltf::Model& model, const std::string& path) {
  const auto too_new = [](const std::string& version) { return !version.starts_with("2."); };
  const tinygltf::Asset& asset = model.asset;
  if (too_new(asset.version)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: asset.version '{}'; export the scene as glTF 2.0", path, asset.version);
  }
  if (!asset.minVersion.empty() && asset.minVersion != "2.0") {
    return MakeStatus(StatusCode::kUnimplemented,
                      "{}: asset.minVersion '{}': only glTF 2.0 is read; export it as that", path,
                      asset.minVersion);
  }
  for (const std::string& extension : model.extensionsRequired) {
    if (std::count(std::begin(kKnownExtensions), std::end(kKnownExtensions), extension) > 0)
      continue;
    return MakeStatus(StatusCode::kUnimplemented,
                      "{}: extensionsRequired: '{}' is not read; export the scene without it", path,
                      extension);
  }
  return {};
}

}  // namespace

Result<std::string> ResolveInside(const std::string& folder, const std::string& uri) {
  const auto refuse = [&] {
    return Error(StatusCode::kPermissionDenied,
                 "uri '{}' leads out of the scene's folder; put the file beside the scene and name "
                 "it relatively",
                 OneLine(uri));
  };
  const size_t colon = uri.find(':');
  const bool scheme = colon != std::string::npos && colon < uri.find('/');
  const fs::path relative(uri);
  const bool climbs = std::count(relative.begin(), relative.end(), "..") > 0;
  if (scheme || relative.is_absolute() || climbs || uri.find('\0') != std::string::npos) {
    return refuse();
  }
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
  const fs::path path = error ? fs::path() : fs::canonical(root / relative, error);
  if (error || !fs::is_regular_file(path, error)) {
    return Error(StatusCode::kNotFound, "uri '{}': no such file beside the scene; put it there",
                 OneLine(uri));
  }
  const auto [root_end, path_end] =
      std::mismatch(root.begin(), root.end(), path.begin(), path.end());
  if (root_end != root.end()) return refuse();
  return path.string();
}

Result<GltfDocument> ReadGltfDocument(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMostGltfBytes));
  return ParseGltfDocument(bytes, path);
}

Result<GltfDocument> ParseGltfDocument(const std::string& bytes, const std::string& path) {
  const bool binary = bytes.starts_with("glTF");
  std::string_view json = bytes;
  if (bytes.size() > kMostGltfBytes) {
    return Error(StatusCode::kResourceExhausted, "{}: {} bytes, more than {}", path, bytes.size(),
                 kMostGltfBytes);
  }
  if (binary) {
    ASSIGN_OR_RETURN(json, CheckBinary(bytes, path));
  }
  RETURN_IF_ERROR(CheckJson(json, path));
  Folder folder;
  folder.path = FolderOf(path);
  tinygltf::TinyGLTF parser;
  parser.SetFsCallbacks(CallbacksOf(&folder));
  parser.SetImageLoader(KeepEncoded, nullptr);
  GltfDocument document;
  document.path = path;
  std::string errors, warnings;
  bool parsed = false;
  const auto size = static_cast<unsigned>(bytes.size());
  try {  // the parser and the JSON library below it throw
    parsed = binary ? parser.LoadBinaryFromMemory(
                          &document.model, &errors, &warnings,
                          reinterpret_cast<const unsigned char*>(bytes.data()), size)
                    : parser.LoadASCIIFromString(&document.model, &errors, &warnings, bytes.data(),
                                                 size, "");
  } catch (const std::exception& exception) {
    errors = exception.what();
  }
  if (!folder.refused.ok()) return tl::unexpected(folder.refused.Within(path));
  if (!parsed && !folder.failed.ok()) return tl::unexpected(folder.failed.Within(path));
  // It leaves out what it cannot read, with a message.
  if (!parsed || !errors.empty()) {
    return Error(StatusCode::kInvalidArgument, "{}: {}; correct the file or export it anew", path,
                 OneLine(errors));
  }
  RETURN_IF_ERROR(CheckAsset(document.model, path));
  return document;
}

}  // namespace isolux
