// Hard cases of whole solves whose answer is known at every point: furnaces, in which everything
// radiates 1 whatever stands where, and black rooms, in which what arrives comes straight from the
// lamp. The latter is found by exact clipping, which the solver does not use.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>

#include "tests/hard_cases/hard_case.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/link_bench.h"
#include "tests/support/local_cluster.h"
#include "tests/support/obj_scene.h"
#include "tests/support/shared_folder.h"
#include "tests/support/solve_scene.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"
#include "worker/radiosity/closure.h"
#include "worker/visibility/clipped_factor.h"

namespace isolux::testing {
namespace {

const RoundSummary& Last(const SolveResult& result) { return result.summary.rounds.back(); }

// Mean |ΔH| over mean H, from the corners of all faces; `exact` of a point of the scene, in metres,
// and the normal there.
// Corners are drawn in by a millionth: on an edge of the scene more than one thing is true.
double ErrorAgainst(const PatchFile& patch, const Scene& scene,
                    const std::function<double(const Vec3& x, const Vec3& n)>& exact) {
  double difference = 0, total = 0;
  for (const PatchFace& face : patch.faces) {
    const size_t count = face.vertices.size();
    const auto at = [&](size_t i) {
      const Vec3& place = patch.vertices[face.vertices[i % count]].position;
      return scene.metres_per_unit * place - scene.origin_m;
    };
    Vec3 area(0.0), middle(0.0);
    for (size_t i = 0; i < count; ++i) {
      area += 0.5 * glm::cross(at(i), at(i + 1));
      middle += at(i) / static_cast<double>(count);
    }
    const double weight = glm::length(area) / static_cast<double>(count);
    for (size_t i = 0; i < count; ++i) {
      const double h = exact(at(i) + 1e-6 * (middle - at(i)), area / glm::length(area));
      difference += weight * std::abs(patch.vertices[face.vertices[i]].irradiance[1] - h);
      total += weight * h;
    }
  }
  return difference / total;
}

// ---- furnaces

// What links, closed as far as they go, make of a furnace.
struct FurnaceErrors {
  double worst = 0;           // |B - 1|
  double worst_residual = 0;  // of rows, before what they lack comes back
};

FurnaceErrors SolveFurnace(const Scene& scene, double most, double share) {
  LinkBench bench(Kirchhoff(scene, most, 23), share);
  const size_t n = bench.system.size();
  const auto closing = bench.CloseRows(1e-6);
  LinkTransport transport(*bench.product, bench.system);
  SolverOptions options;
  options.accuracy = 1e-8;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, bench.system,
                            std::vector<Lanes>(n), options, bench.exchange);
  FurnaceErrors errors;
  EXPECT_TRUE(closing.has_value() && solved.has_value());
  if (!closing.has_value() || !solved.has_value()) return errors;
  errors.worst_residual = closing->worst_after;
  for (size_t i = 0; i < n; ++i) {
    const Lanes b =
        bench.system.exitance[i] + bench.system.reflectance[i] * solved->irradiance[i] - 1.0;
    for (int c = 0; c < 3; ++c) errors.worst = std::max(errors.worst, std::abs(b[c]));
  }
  return errors;
}

TEST(HardExactRooms, KirchhoffFurnaces) {
  HardCase one("23a",
               "E = 1 - rho, random rho up to .9 and .999, over links: L, column, Cornell box",
               "|B - 1|", 1e-6);
  const auto measure = [&](const char* name, const Scene& scene) {
    for (const double most : {0.9, 0.999}) {
      const FurnaceErrors errors = SolveFurnace(scene, most, 1e-3);
      one.Measure(errors.worst, fmt::format("{}, rho to {}, rows off by {:.2g} before", name, most,
                                            errors.worst_residual));
    }
  };
  measure("L", LRoom());
  measure("column", ColumnRoom());
  measure("Cornell box", ClosedCornellBox());
}

// The scene in the middle of an empty closed room, so that no light escapes.
Scene Enclosed(Scene scene) {
  Bounds3 bounds;
  for (const Vec3& v : scene.vertices) bounds.Add(v);
  const Vec3 margin(0.1 * bounds.Diagonal());
  SceneSketch sketch(std::move(scene));
  sketch.Box(bounds.low - margin, bounds.high + margin, true, sketch.Material("shell", 0.5),
             kFrontTakesPart);
  return sketch.Take();
}

TEST(HardExactRooms, KirchhoffFurnacesAmongFurniture) {
  const std::string folder = SharedFolder() + "/scenes";
  if (!std::filesystem::is_directory(folder)) {
    GTEST_SKIP() << "no collection of scenes; name its folder in ISOLUX_SHARED";
  }
  const std::string situation =
      "E = 1 - rho, random rho up to .99, over links: an office, a room of cubes, in a closed "
      "shell";
  HardCase worst("23b", situation, "largest |B - 1|", 1e-6);
  HardCase solved("23d", "the same, rho up to .9, solved to 10 %",
                  "mean |H - 1| over the error estimate", 1);
  for (const std::string name : {"simple_office", "rp_cube"}) {
    const auto scene = ImportScene(fmt::format("{0}/{1}/{1}.obj", folder, name), {});
    ASSERT_TRUE(scene.has_value()) << scene.error().message();
    const FurnaceErrors errors = SolveFurnace(Enclosed(*scene), 0.99, 1e-3);
    worst.Measure(errors.worst,
                  fmt::format("{}, rows off by {:.2g} before", name, errors.worst_residual));
    const Scene furnace = Kirchhoff(Enclosed(*scene), 0.9, 24);
    const SolveResult result = SolveScene(furnace, 0.1);
    const double error =
        ErrorAgainst(result.patch, furnace, [](const Vec3&, const Vec3&) { return 1.0; });
    solved.Measure(error / Last(result).error_estimate, name);
  }
}

// ---- black rooms

// What arrives at points of a black scene straight from its lamps.
class DirectLight {
 public:
  explicit DirectLight(const Scene& scene)
      : occluders_(MakeOccluders(scene)), clipper_(occluders_.set) {
    for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
      const Material& material = scene.materials[scene.polygons[p].material];
      for (const Side side : {Side::kFront, Side::kBack}) {
        const uint8_t emits = side == Side::kFront ? kFrontEmits : kBackEmits;
        if ((scene.polygons[p].sides & emits) == 0) continue;
        Lamp lamp{SideGeometry(scene, p, side), material.exitance[1], {}};
        for (uint32_t i = 0; i < occluders_.set.size(); ++i) {
          if (occluders_.set[i].region != occluders_.region_of[p]) lamp.before_it.push_back(i);
        }
        lamps_.push_back(std::move(lamp));
      }
    }
  }

  double At(const Vec3& x, const Vec3& n) {
    double sum = 0;
    for (const Lamp& lamp : lamps_) {
      if (glm::dot(lamp.shape.Normal(), x - lamp.shape.v[0]) <= 1e-9) continue;
      const ClippedPolygon above = ClipToFront(lamp.shape, x, n, 1e-12);
      if (above.count < 3) continue;
      const double whole = PointFormFactors(Vec3x4({x, x, x, x}), n, above.corners())[0];
      sum += lamp.exitance * clipper_.VisibleFactor(x, n, above.corners(), lamp.before_it, whole);
    }
    return sum;
  }

 private:
  struct Lamp {
    ConvexPolygon shape;
    double exitance = 0;
    std::vector<uint32_t> before_it;  // all occluders but what is of one wall with it
  };
  SceneOccluders occluders_;
  PointClipper clipper_;
  std::vector<Lamp> lamps_;
};

Scene Black(Scene scene) {
  for (Material& material : scene.materials) material.reflectance = Rgb(0.0);
  return scene;
}

TEST(HardExactRooms, ErrorsFallAsAsked) {
  const std::string situation =
      "two black furnished rooms at 10, 3, 1 and .3 %, a furnished furnace at the first three";
  HardCase falls("31", situation, "true error over that at the accuracy before, mean of the rooms",
                 1);
  HardCase honest("31a", "the same",
                  "true error over twice the estimate, or estimate over ten times the true error",
                  1);
  HardCase kept("31b", "the same", "true error over the accuracy asked for", 1);
  struct Room {
    const char* name;
    Scene scene;
    bool black;
    double before = 0;  // true error at the accuracy before
  };
  Room rooms[] = {{"black room", Black(FurnishedRoom()), true},
                  {"black Cornell box", Black(ClosedCornellBox()), true},
                  {"furnace", Kirchhoff(FurnishedRoom(), 0.9, 31), false}};
  for (const double accuracy : {0.1, 0.03, 0.01, 0.003}) {
    double logarithm = 0;
    int compared = 0;
    for (Room& room : rooms) {
      if (!room.black && accuracy < 0.01) continue;
      const SolveResult result = SolveScene(room.scene, accuracy);
      DirectLight direct(room.scene);
      const double error = ErrorAgainst(
          result.patch, room.scene,
          [&](const Vec3& x, const Vec3& n) { return room.black ? direct.At(x, n) : 1.0; });
      const double estimate = Last(result).error_estimate;
      const std::string where = fmt::format("{} at {}: true error {:.2g}, estimate {:.2g}",
                                            room.name, accuracy, error, estimate);
      std::printf("%s, %llu links\n", where.c_str(),
                  static_cast<unsigned long long>(Last(result).links));
      honest.Measure(std::max(0.5 * error / estimate, 0.1 * estimate / error), where);
      kept.Measure(error / accuracy, where);
      if (room.before > 0) {
        logarithm += std::log(error / room.before);
        ++compared;
      }
      room.before = error;
    }
    if (compared > 0) falls.Measure(std::exp(logarithm / compared), fmt::format("{}", accuracy));
  }
}

// ---- an emitter under a cover

// A room whose floor is a lamp, its middle covered at this height; at none the lamp is the frame
// around the cover. Polygons: five walls, the cover, the lamp.
Scene CoveredLamp(std::optional<double> gap) {
  ObjScene room;
  room.Box("white", {0, 0, 0}, {1, 1, 1}, false, true, true);
  room.Level("blue", 0.25, 0.25, 0.75, 0.75, gap.value_or(0));
  if (gap.has_value()) {
    room.Level("lamp", 0, 0, 1, 1, 0);
  } else {
    room.Level("lamp", 0, 0, 1, 0.25, 0);
    room.Level("lamp", 0, 0.75, 1, 1, 0);
    room.Level("lamp", 0, 0.25, 0.25, 0.75, 0);
    room.Level("lamp", 0.75, 0.25, 1, 0.75, 0);
  }
  return room.Import();
}

TEST(HardExactRooms, CoverJustAboveALamp) {
  HardCase frame("17", "a lamp whose middle is covered at 1e-3 to 1e-9, whole solves",
                 "difference from the uncovered frame, wall by wall, over the estimates", 1);
  HardCase acne("17a", "the same, of the cover's front", "|H / H in the frame - 1| of a face", 0.1);
  // Of the walls and of the cover's front, W; and of faces of the latter, W/m².
  const auto powers = [](const SolveResult& result, std::vector<double>* cover) {
    std::array<double, 6> power{};
    for (const PatchFace& face : result.patch.faces) {
      const bool front = face.polygon < 5 || face.side == 0;
      if (face.polygon > 5 || !front) continue;
      PatchFile one;
      one.vertices = result.patch.vertices;
      one.faces = {face};
      power[face.polygon] += ArrivingAt(one, 0);
      if (face.polygon == 5) cover->push_back(face.irradiance[0]);
    }
    return power;
  };
  constexpr double kAccuracy = 0.03;
  std::vector<double> even;
  const SolveResult uncovered = SolveScene(CoveredLamp(std::nullopt), kAccuracy);
  const auto expected = powers(uncovered, &even);
  for (const double gap : {1e-3, 1e-4, 1e-5, 1e-6, 1e-9}) {
    std::vector<double> cover;
    const SolveResult result = SolveScene(CoveredLamp(gap), kAccuracy);
    const auto found = powers(result, &cover);
    double difference = 0, total = 0;
    for (int p = 0; p < 6; ++p) {
      difference += std::abs(found[p] - expected[p]);
      total += expected[p];
    }
    const std::string where = fmt::format("gap {:g}", gap);
    frame.Measure(
        difference / total / (Last(result).error_estimate + Last(uncovered).error_estimate), where);
    double mean = 0;
    for (const double h : even) mean += h / static_cast<double>(even.size());
    for (const double h : cover) acne.Measure(std::abs(h / mean - 1), where);
  }
}

}  // namespace
}  // namespace isolux::testing
