// Error against links, without mesh or network: one process refines a scene round by round and,
// after each, compares with true irradiance at points (see truth.cc) what the leaves hold and what
// is gathered at the points themselves.
//
//   convergence SCENE.obj POINTS.csv [--emit both] [--rounds N] [--step FACTOR] [--accuracy A]
//     Prints CSV: ε over emitted power, links, leaves, rays, seconds of refinement and solution,
//     error of the leaves' constants, error gathered at accuracy A (its rays), microseconds a
//     point, estimated error and its parts, energy imbalance.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "client/import/import.h"
#include "common/hierarchy/element.h"
#include "worker/shard.h"

namespace isolux {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Point {
  NodeId element;  // a speck that holds the point
  Vec3 position{0.0};
  Rgb irradiance{0.0}, deviation{0.0};
};

double DistanceOutside(const ConvexPolygon& polygon, const Vec3& n, const Vec3& x) {
  double outside = std::abs(glm::dot(n, x - polygon.v[0]));
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 side = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    outside =
        std::max(outside, -glm::dot(glm::cross(n, side), x - polygon.v[i]) / glm::length(side));
  }
  return outside;
}

NodeId SpeckAt(const Hierarchy& hierarchy, uint32_t surface, const Vec3& x) {
  NodeId id{surface, 1};
  ConvexPolygon polygon = hierarchy.geometry(surface);
  const Vec3 n = polygon.Normal();
  while (id.level() < 30) {
    const auto parts = Subdivide(polygon);
    const int k = DistanceOutside(parts[0], n, x) <= DistanceOutside(parts[1], n, x) ? 0 : 1;
    id = id.Child(k);
    polygon = parts[k];
  }
  return id;
}

std::vector<Point> ReadPoints(const char* path, const Scene& scene, const Hierarchy& hierarchy) {
  std::vector<Point> points;
  std::ifstream in(path);
  std::string line;
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    Point p;
    Vec3 normal;
    for (Vec3* v : {&p.position, &normal, &p.irradiance, &p.deviation}) row >> v->x >> v->y >> v->z;
    p.position = p.position * scene.metres_per_unit - scene.origin_m;
    double best = 1e-4 * hierarchy.extent_m();
    uint32_t surface = 0xffffffffu;
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
      const ConvexPolygon& polygon = hierarchy.geometry(s);
      if (glm::dot(polygon.Normal(), normal) < 0.999) continue;
      const double outside = DistanceOutside(polygon, polygon.Normal(), p.position);
      if (outside >= best) continue;
      best = outside;
      surface = s;
    }
    if (surface == 0xffffffffu) continue;
    p.element = SpeckAt(hierarchy, surface, p.position);
    points.push_back(p);
  }
  return points;
}

struct Tally {
  double error = 0, mean = 0;
  void Add(const Rgb& found, const Point& point) {
    for (int c = 0; c < 3; ++c) {
      const double e = std::abs(found[c] - point.irradiance[c]), d = point.deviation[c];
      error += std::sqrt(std::max(0.0, e * e - 0.64 * d * d));
      mean += point.irradiance[c];
    }
  }
  double Relative() const { return error / mean; }
};

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  using namespace isolux;
  if (argc < 3) {
    std::fprintf(stderr, "usage: convergence SCENE.obj POINTS.csv [...]\n");
    return 2;
  }
  ImportOptions import;
  int rounds = 9;
  double step = 0.25, accuracy = 0.01, first = 0.02;
  for (int i = 3; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--emit") == 0)
      import.emit_both = std::strcmp(argv[i + 1], "both") == 0;
    if (std::strcmp(argv[i], "--rounds") == 0) rounds = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--step") == 0) step = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--accuracy") == 0) accuracy = std::atof(argv[i + 1]);
  }
  Result<Scene> read = ImportScene(argv[1], import);
  if (!read) {
    std::fprintf(stderr, "%s\n", read.error().message().c_str());
    return 2;
  }
  const auto scene = std::make_shared<const Scene>(std::move(*read));
  const Hierarchy hierarchy(*scene);
  std::vector<Point> points = ReadPoints(argv[2], *scene, hierarchy);
  std::sort(points.begin(), points.end(),
            [](const Point& a, const Point& b) { return a.element < b.element; });

  ThreadPool pool(0);
  Shard shard(scene, &pool);
  SolveOptions options;
  options.accuracy = accuracy;
  const Assignment assignment{{NodeId{NodeId::kCluster, 0}}, {0}, 1};
  if (!shard.Start(options, assignment, 0).ok()) return 1;
  NullExchange exchange;
  std::printf(
      "epsilon,links,leaves,rays,refine_s,solve_s,constants,gathered,gather_rays,us_per_point,"
      "estimate,spread,visibility,coupling,solver,imbalance\n");
  double share = first;
  for (int r = 0; r < rounds; ++r, share *= step) {
    const double epsilon = share * Sum(shard.EmittedPower());
    const auto report = shard.RunRound(epsilon, std::min(0.1, accuracy), exchange);
    if (!report) {
      std::fprintf(stderr, "%s\n", report.error().message().c_str());
      return 1;
    }
    const Snapshot snapshot = shard.TakeSnapshot();
    if (!shard.InstallSnapshot(snapshot).ok()) return 1;
    std::vector<NodeId> ids;
    for (const Point& p : points) ids.push_back(p.element);
    const double start = Now();
    const auto part = shard.Gather(ids, std::vector<uint8_t>(ids.size(), 1), accuracy);
    if (!part) {
      std::fprintf(stderr, "%s\n", part.error().message().c_str());
      return 1;
    }
    const double gather_s = Now() - start;
    Tally constants, gathered;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto leaf = std::find_if(snapshot.leaves.begin(), snapshot.leaves.end(),
                                     [&](const LeafRecord& l) { return Contains(l.id, ids[i]); });
      constants.Add(Rgb(leaf->irradiance[0], leaf->irradiance[1], leaf->irradiance[2]), points[i]);
      Rgb h;
      for (int c = 0; c < 3; ++c) {
        h[c] = std::ldexp(static_cast<double>(part->sums[12 * i + c]), -part->exponent);
      }
      gathered.Add(h, points[i]);
      if (getenv("DBG") != nullptr && r + 1 == rounds) {
        const Vec3 f = (points[i].position + scene->origin_m) / scene->metres_per_unit;
        std::printf("P,%.1f,%.1f,%.1f,surf %u,leaf level %d,true %.4f,got %.4f,const %.4f\n", f.x,
                    f.y, f.z, ids[i].surface, leaf->id.level(), Sum(points[i].irradiance), Sum(h),
                    double(leaf->irradiance[0]) + leaf->irradiance[1] + leaf->irradiance[2]);
      }
    }
    std::printf("%.3g,%lu,%lu,%lu,%.3f,%.3f,%.4f,%.4f,%.0f,%.1f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n",
                share, report->links, report->leaves, report->rays, report->refine_s,
                report->solve_s, constants.Relative(), gathered.Relative(),
                static_cast<double>(part->rays) / static_cast<double>(points.size()),
                1e6 * gather_s / static_cast<double>(points.size()) * pool.thread_count(),
                report->error_estimate, report->error_spread, report->error_visibility,
                report->error_coupling, report->error_solver, report->energy_imbalance);
    std::fflush(stdout);
  }
  return 0;
}
