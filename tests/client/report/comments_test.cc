#include "client/report/comments.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace isolux {
namespace {

using nlohmann::json;

json Read(std::vector<std::pair<std::string, std::string>> comments) {
  PatchFile file;
  file.comments = std::move(comments);
  return ReadComments(file);
}

TEST(ReportCommentsTest, WhatStandsOnceIsANumberAListOrText) {
  const json summary = Read({{"accuracy", "0.05"},
                             {"epsilons", "5.4 0.34 2e-3"},
                             {"end_reason", "accuracy reached"},
                             {"gather_cpu_s", "1.5"},
                             {"later_key", "x 1"}})["summary"];
  EXPECT_EQ(summary["accuracy"], 0.05);
  EXPECT_EQ(summary["epsilons"], json({5.4, 0.34, 2e-3}));
  EXPECT_EQ(summary["end_reason"], "accuracy reached");
  EXPECT_EQ(summary["gather_cpu_s"], 1.5);
  EXPECT_EQ(summary["later_key"], "x 1");
}

TEST(ReportCommentsTest, NamesThatLookLikeNumbersAreText) {
  const json summary =
      Read({{"scene", "17"}, {"scene_hash", "00120000000000000000000000000012"}})["summary"];
  EXPECT_EQ(summary["scene"], "17");
  EXPECT_EQ(summary["scene_hash"], "00120000000000000000000000000012");
}

TEST(ReportCommentsTest, RoundsAndTraffic) {
  const json data = Read({{"round", "1 epsilon 0.5 error 0.1 cpu_s 1.5,2.5"},
                          {"round", "2 epsilon 0.1 error 0.05 cpu_s 3 odd"},
                          {"traffic", "values bytes_in 10 bytes_out 20"},
                          {"worker_traffic", "2 gather bytes_in 1 bytes_out 0"}});
  ASSERT_EQ(data["rounds"].size(), 2u);
  EXPECT_EQ(data["rounds"][0],
            json({{"round", 1}, {"epsilon", 0.5}, {"error", 0.1}, {"cpu_s", {1.5, 2.5}}}));
  EXPECT_EQ(data["rounds"][1]["cpu_s"], 3);
  EXPECT_FALSE(data["rounds"][1].contains("odd"));
  EXPECT_EQ(data["traffic"][0], json({{"phase", "values"}, {"bytes_in", 10}, {"bytes_out", 20}}));
  EXPECT_EQ(data["worker_traffic"][0],
            json({{"worker", 2}, {"phase", "gather"}, {"bytes_in", 1}, {"bytes_out", 0}}));
}

TEST(ReportCommentsTest, EffectsAndRepairs) {
  const json data =
      Read({{"effect",
             "mirror not-simulated present yes bound 0.03 evidence 2 materials; bound too small"},
            {"effect", "sky off present no bound - measured 2e-4 evidence none; nothing"},
            {"repair", "3 faces divided (room.obj:17)"}});
  EXPECT_EQ(data["effects"][0], json({{"name", "mirror"},
                                      {"decision", "not-simulated"},
                                      {"present", true},
                                      {"bound", 0.03},
                                      {"evidence", "2 materials; bound too small"}}));
  EXPECT_EQ(data["effects"][1]["present"], false);
  EXPECT_EQ(data["effects"][1]["bound"], json());
  EXPECT_EQ(data["effects"][1]["measured"], 2e-4);
  EXPECT_EQ(data["repairs"], json({{{"count", 3}, {"what", "faces divided (room.obj:17)"}}}));
}

TEST(ReportCommentsTest, DamagedLinesDoNoHarm) {
  for (const char* key : {"round", "traffic", "worker_traffic", "effect", "repair", "accuracy"}) {
    for (const char* value :
         {"", " ", "1", "a", "1 2 3 4", " evidence ", "x present", "1e999", ",,", "1,"}) {
      EXPECT_TRUE(Read({{key, value}}).is_object()) << key << " '" << value << "'";
    }
  }
}

}  // namespace
}  // namespace isolux
