// From materials that light passes to panes of glass.
#pragma once

#include <vector>

#include "client/import/repair.h"
#include "client/import/scene_file.h"
#include "common/scene/glazing.h"

namespace isolux {

// Whether faces of the material are panes: what passes is more than what is reflected diffusely,
// together they are no more than what arrives, and it emits nothing. Others stay opaque.
bool IsPane(const FileMaterial& material);

// Takes the polygons of such materials out of the scene and makes panes of them. `glasses` has one
// for each of the file's materials; only those of panes count. Where two panes of one material lie
// so near and parallel that they are the faces of a slab, each is a half of it.
void MovePanes(const SceneFile& file, const std::vector<Glass>& glasses, Scene* scene,
               RepairLog* log);

}  // namespace isolux
