// The page of `isolux report`: what one solve took and reached, and where its error is.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "client/output/camera.h"
#include "common/scene/patch_file.h"
#include "common/util/parallel.h"
#include "common/util/status.h"

namespace isolux {

struct ReportOptions {
  std::string name;              // what the page is named by where the file names no scene
  std::optional<Camera> camera;  // of the pictures; otherwise GuessCamera's
  int up = 0;                    // as of GuessCamera
  int picture_side = 640;        // pixels, the longer one
  nlohmann::json job;            // as `isolux status --json` prints it; null: not known
};

// What docs/report.md describes. The pictures are made anew. Fails where the file has no rounds or
// faces to speak of.
Result<nlohmann::json> MakeReportData(const PatchFile& file, const ReportOptions& options,
                                      ThreadPool& pool);

// The whole HTML file.
Result<std::string> MakeReport(const PatchFile& file, const ReportOptions& options,
                               ThreadPool& pool);

}  // namespace isolux
