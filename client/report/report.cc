#include "client/report/report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/output/error_map.h"
#include "client/report/comments.h"
#include "client/report/forecasts.h"
#include "client/web/page.h"

namespace isolux {
namespace {

using nlohmann::json;

constexpr int kPictureSamples = 9;   // rays a pixel
constexpr size_t kMostPolygons = 8;  // that are named for their error
constexpr double kUsualAccuracy = 0.02;
// The colours reach from a tenth of the accuracy asked for to ten times as much.
constexpr double kColourSpan = 10;

// The camera's view, its longer side so many pixels.
Camera Fit(Camera camera, int side) {
  const double scale = static_cast<double>(side) / std::max({camera.width, camera.height, 1});
  camera.width = std::max(1, static_cast<int>(std::lround(scale * camera.width)));
  camera.height = std::max(1, static_cast<int>(std::lround(scale * camera.height)));
  return camera;
}

std::string Hex(const std::array<uint8_t, 3>& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

// A picture of `rgb` as the page shows it.
Result<json> Picture(const Camera& camera, const std::vector<uint8_t>& rgb) {
  ASSIGN_OR_RETURN(const std::string png, EncodePng(camera.width, camera.height, rgb));
  return json(DataAddress("image/png", png));
}

Result<json> Pictures(const PatchFile& file, const RelativeErrors& errors, double accuracy,
                      const ReportOptions& options, ThreadPool& pool) {
  ASSIGN_OR_RETURN(const PatchScene scene, PatchScene::Build(file));
  const Camera camera =
      Fit(options.camera ? *options.camera : GuessCamera(scene, options.up), options.picture_side);
  RenderOptions render;
  render.samples = kPictureSamples;
  const FalseColours colours{accuracy / kColourSpan, std::min(accuracy * kColourSpan, 1.0)};
  ASSIGN_OR_RETURN(json map,
                   Picture(camera, RenderErrors(scene, camera, render, errors, colours, pool)));
  const Exposure exposure = AutoExposure(scene, camera, ToneMap::kReinhard, 0);
  render.brightest = exposure.WhiteLuminance();
  const Image image = Render(scene, camera, render, pool);
  ASSIGN_OR_RETURN(json solution, Picture(camera, ToDisplay(image, exposure)));
  json stops = json::array();
  for (const auto& stop : FalseColours::Stops()) stops.push_back(Hex(stop));
  return json{{"width", camera.width}, {"height", camera.height}, {"solution", solution},
              {"error", map},          {"low", colours.low},      {"high", colours.high},
              {"colours", stops}};
}

// Polygons of the scene file by their share of the whole error, the largest first.
json WorstPolygons(const PatchFile& file, const RelativeErrors& errors) {
  struct Sum {
    uint32_t polygon = 0;
    double area = 0, error = 0, worst = 0;
  };
  std::map<uint32_t, Sum> sums;
  double whole = 0;
  for (size_t i = 0; i < file.faces.size(); ++i) {
    Sum& sum = sums[file.faces[i].polygon];
    sum.polygon = file.faces[i].polygon;
    sum.area += errors.area[i];
    sum.error += errors.area[i] * errors.of_face[i];
    sum.worst = std::max(sum.worst, errors.of_face[i]);
    whole += errors.area[i] * errors.of_face[i];
  }
  std::vector<Sum> order;
  for (const auto& [polygon, sum] : sums) {
    if (sum.area > 0 && sum.error > 0) order.push_back(sum);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Sum& a, const Sum& b) { return a.error > b.error; });
  order.resize(std::min(order.size(), kMostPolygons));
  json list = json::array();
  for (const Sum& sum : order) {
    list.push_back({{"polygon", sum.polygon},
                    {"share", sum.error / whole},
                    {"mean", sum.error / sum.area},
                    {"worst", sum.worst},
                    {"area", sum.area}});
  }
  return list;
}

}  // namespace

Result<json> MakeReportData(const PatchFile& file, const ReportOptions& options, ThreadPool& pool) {
  json data = ReadComments(file);
  if (file.faces.empty() || data["rounds"].empty()) {
    return Error(StatusCode::kInvalidArgument,
                 "has {}: it does not say how it was solved, so there is nothing to report",
                 file.faces.empty() ? "no faces" : "no rounds");
  }
  const RelativeErrors errors = FindRelativeErrors(file);
  const json& summary = data["summary"];
  const auto asked = summary.find("accuracy");
  double accuracy = asked != summary.end() && asked->is_number() ? asked->get<double>() : 0;
  if (!(accuracy > 0 && accuracy <= 1)) accuracy = kUsualAccuracy;
  data["forecasts"] = MakeForecasts(data["rounds"], accuracy);
  ASSIGN_OR_RETURN(data["pictures"], Pictures(file, errors, accuracy, options, pool));
  data["faces"] = {{"count", file.faces.size()},
                   {"mean_irradiance_w_m2", errors.mean_irradiance_w_m2},
                   {"error_mean", errors.mean},
                   {"error_p95", errors.p95},
                   {"worst_polygons", WorstPolygons(file, errors)}};
  data["name"] = summary.contains("scene") ? summary["scene"] : json(options.name);
  data["job"] = options.job;
  return data;
}

Result<std::string> MakeReport(const PatchFile& file, const ReportOptions& options,
                               ThreadPool& pool) {
  ASSIGN_OR_RETURN(const json data, MakeReportData(file, options, pool));
  return MakePage(PageKind::kReport, data["name"].get<std::string>() + ": report", data);
}

}  // namespace isolux
