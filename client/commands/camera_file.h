// What --camera names: a camera.json, or a camera of a glTF scene.
#pragma once

#include <string>

#include "client/import/gltf_document.h"
#include "client/output/camera.h"

namespace isolux {

// FILE.json as ReadCamera takes it; or FILE.gltf or FILE.glb: its first camera, with :N the N-th
// from 0 in the order of the node tree, with :NAME that of a node or camera of this name.
Result<Camera> ReadCameraOf(const std::string& argument);

// A perspective camera of the document's scene, in the file's unit: where its node is, 960 pixels
// high, as wide as its aspect ratio says (4:3 where it says none). An error names those there are
// where `which` is none of them, and the camera where it is orthographic.
Result<Camera> CameraOf(const GltfDocument& document, const std::string& which);

}  // namespace isolux
