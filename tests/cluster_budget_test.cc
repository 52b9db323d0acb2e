// Budgets and forecasts on a running cluster, in one process: what a run is allowed is used, and
// what it will take is known before it is there.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "client/import/import.h"
#include "common/hierarchy/hierarchy.h"
#include "common/scene/forecast.h"
#include "tests/support/local_cluster.h"
#include "tests/support/scenes.h"

namespace isolux::testing {
namespace {

struct Case {
  const char* name;
  Scene scene;
  uint64_t links;   // a budget
  double accuracy;  // that takes some rounds
};

std::vector<Case> Cases() {
  auto room = ImportScene(std::string(ISOLUX_SOURCE_DIR) + "/scenes/room.obj", {});
  EXPECT_TRUE(room.has_value());
  std::vector<Case> cases;
  cases.push_back({"room.obj", room ? std::move(*room) : Scene(), 60'000, 0.05});
  cases.push_back({"Cornell box", CornellBox(false), 12'000, 0.012});
  cases.push_back({"random room", RandomRoom(7, 5), 20'000, 0.015});
  return cases;
}

struct Course {
  std::vector<RoundSummary> rounds;
  Snapshot last;
};

// The rounds of a job, without its gather.
Course RoundsOf(const Scene& scene, const SolveOptions& options) {
  LocalCluster cluster(2, 1);
  Course run;
  bool gathering = false;
  JobCallbacks callbacks;
  callbacks.on_round = [&](const RoundSummary& round) { run.rounds.push_back(round); };
  callbacks.on_snapshot = [&](const Snapshot& snapshot) {
    run.last = snapshot;
    return Status();
  };
  callbacks.on_progress = [&](const JobProgress& progress) {
    gathering |= progress.stage == JobProgress::Stage::kGathering;
  };
  callbacks.cancelled = [&] { return gathering; };
  const auto result = RunJob(cluster, MakeJobInput(scene, options), callbacks);
  EXPECT_TRUE(gathering && !result.has_value());
  EXPECT_FALSE(run.rounds.empty());
  if (run.rounds.empty()) run.rounds.emplace_back();
  return run;
}

void ExpectUsed(const Case& c, const Course& run, uint64_t RoundSummary::*member, uint64_t limit) {
  for (const RoundSummary& round : run.rounds) {
    EXPECT_LE(static_cast<double>(round.*member), 1.05 * static_cast<double>(limit)) << c.name;
  }
  EXPECT_GE(static_cast<double>(run.rounds.back().*member), 0.9 * static_cast<double>(limit))
      << c.name;
}

TEST(BudgetTest, LinksAreUsedToTheLastTenth) {
  for (const Case& c : Cases()) {
    SolveOptions options;
    options.accuracy = 0.001;
    options.max_links = c.links;
    ExpectUsed(c, RoundsOf(c.scene, options), &RoundSummary::links, c.links);
  }
}

TEST(BudgetTest, MemoryIsUsedToTheLastTenth) {
  for (const Case& c : Cases()) {
    SolveOptions options;
    options.accuracy = 0.001;
    options.max_memory_bytes = 150 * c.links;
    ExpectUsed(c, RoundsOf(c.scene, options), &RoundSummary::memory_bytes,
               options.max_memory_bytes);
  }
}

// Σ A |H_a − H_b| over the finer of the leaves of two solutions.
double Difference(const Hierarchy& hierarchy, const Snapshot& a, const Snapshot& b) {
  double sum = 0;
  for (size_t i = 0, k = 0; i < a.leaves.size() && k < b.leaves.size();) {
    const bool first = Contains(b.leaves[k].id, a.leaves[i].id);  // a's leaf is the finer one
    const NodeId& id = first ? a.leaves[i].id : b.leaves[k].id;
    const double area = std::ldexp(hierarchy.surface_area_m2(id.surface), -id.level());
    for (int c = 0; c < 3; ++c) {
      sum += area * std::abs(a.leaves[i].irradiance[c] - b.leaves[k].irradiance[c]);
    }
    const bool same = a.leaves[i].id == b.leaves[k].id;
    const auto next_is_inside = [&](const Snapshot& fine, size_t at, const NodeId& coarse) {
      return at + 1 < fine.leaves.size() && Contains(coarse, fine.leaves[at + 1].id);
    };
    if (same) {
      ++i, ++k;
    } else if (first) {
      if (!next_is_inside(a, i, b.leaves[k].id)) ++k;
      ++i;
    } else {
      if (!next_is_inside(b, k, a.leaves[i].id)) ++i;
      ++k;
    }
  }
  return sum;
}

// What many small steps make of a budget is no worse than what the usual steps make of as many
// links.
TEST(BudgetTest, IsSpentAsWellAsAnAccuracySpendsIt) {
  for (const Case& c : Cases()) {
    if (std::string(c.name) == "room.obj") continue;  // its reference would take long
    SolveOptions budget;
    budget.accuracy = 0.001;
    budget.max_links = c.links;
    const Course spent = RoundsOf(c.scene, budget);
    SolveOptions usual;
    for (double epsilon = spent.rounds[0].epsilon; epsilon > spent.rounds.back().epsilon;
         epsilon /= 16) {
      usual.epsilons.push_back(epsilon);
    }
    usual.epsilons.push_back(spent.rounds.back().epsilon);
    const Course plain = RoundsOf(c.scene, usual);
    usual.epsilons.push_back(usual.epsilons.back() / 16);
    const Course reference = RoundsOf(c.scene, usual);
    const Hierarchy hierarchy(c.scene);
    const double of_budget = Difference(hierarchy, spent.last, reference.last);
    const double of_plain = Difference(hierarchy, plain.last, reference.last);
    const double links = static_cast<double>(spent.rounds.back().links) /
                         static_cast<double>(plain.rounds.back().links);
    RecordProperty(std::string("links_") + c.name, std::to_string(links));
    // With as many links; error ~ links^-1/2.
    EXPECT_LE(of_budget * std::sqrt(links), 1.1 * of_plain) << c.name;
  }
}

// Before each of the last two rounds its links are known, and before the last one those of the
// whole run. Of all that a run takes the links decide; times are not tested.
TEST(ForecastTest, LinksAreKnownBeforeTheyAreMade) {
  for (const Case& c : Cases()) {
    SolveOptions options;
    options.accuracy = c.accuracy;
    const std::vector<RoundSummary> rounds = RoundsOf(c.scene, options).rounds;
    std::string told;
    for (const RoundSummary& round : rounds) {
      told += fmt::format("\nepsilon {:.3g} error {:.4f} links {}", round.epsilon,
                          round.error_estimate, round.links);
    }
    SCOPED_TRACE(c.name + told);
    ASSERT_GE(rounds.size(), 3u);
    const std::span all(rounds);
    const auto expect_near = [](double expected, uint64_t links) {
      EXPECT_LE(expected, 1.5 * static_cast<double>(links));
      EXPECT_GE(expected, static_cast<double>(links) / 1.5);
    };
    for (size_t k = rounds.size() - 2; k < rounds.size(); ++k) {
      expect_near(RunFit(all.first(k)).links().At(rounds[k].epsilon), rounds[k].links);
    }
    const auto forecast = ForecastRun(all.first(rounds.size() - 1), options.accuracy);
    ASSERT_TRUE(forecast.has_value());
    expect_near(forecast->links.likely, rounds.back().links);
  }
}

}  // namespace
}  // namespace isolux::testing
