// A glTF 2.0 document as its parser gives it: container, syntax, versions and extensions are
// checked, files are read from the scene's own folder alone. Numbers and indices are not checked
// yet: whoever uses one does so.
#pragma once

#include <tiny_gltf.h>

#include <string>

#include "common/util/status.h"

namespace isolux {

struct GltfDocument {
  std::string path;
  // Images hold their encoded bytes (Image::image), but for those in a buffer view.
  tinygltf::Model model;

  // An error about an element, for instance "meshes[3].primitives[0]": a Status or any Result.
  template <typename... Args>
  internal::Failure Error(StatusCode code, const std::string& element,
                          fmt::format_string<Args...> format, Args&&... args) const {
    const std::string what = fmt::format(format, std::forward<Args>(args)...);
    return {MakeStatus(code, "{}: {}: {}", path, element, what)};
  }
};

Result<GltfDocument> ReadGltfDocument(const std::string& path);
// The same from bytes, text or binary; other files are looked for beside `path`.
Result<GltfDocument> ParseGltfDocument(const std::string& bytes, const std::string& path);

// The file that a relative `uri` (percent-decoded) names in `folder` or below. Absolute names,
// schemes, "..", and links that lead out of the folder are refused (kPermissionDenied).
Result<std::string> ResolveInside(const std::string& folder, const std::string& uri);

}  // namespace isolux
