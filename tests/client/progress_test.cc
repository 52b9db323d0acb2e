#include "client/progress.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "client/job_text.h"

namespace isolux {
namespace {

TEST(ProgressTest, ShareDoneGoesFromNothingToAll) {
  EXPECT_EQ(ShareDone(0, 0, 0.02), 0) << "before the first round";
  EXPECT_EQ(ShareDone(0.2, 0.2, 0.02), 0);
  EXPECT_NEAR(ShareDone(0.2, 0.0632455, 0.02), 0.5, 1e-5);
  EXPECT_EQ(ShareDone(0.2, 0.02, 0.02), 1);
  EXPECT_EQ(ShareDone(0.2, 0.001, 0.02), 1);
  EXPECT_EQ(ShareDone(0.2, 0.5, 0.02), 0) << "a round may be worse";
  EXPECT_EQ(ShareDone(0.01, 0.01, 0.02), 1) << "good from the start";
}

TEST(ProgressTest, TheForecastSaysWhatIsStillToCome) {
  EXPECT_EQ(ForecastText({}, 0.02, 0), "");
  std::vector<RoundSummary> rounds(3);
  for (uint32_t i = 0; i < 3; ++i) {
    rounds[i].round = i + 1;
    rounds[i].epsilon = std::pow(0.1, i);
    rounds[i].error_estimate = 0.1641 * std::pow(0.5, i);
    rounds[i].links = static_cast<uint64_t>(30'000 * std::pow(5.5, i));
    rounds[i].seconds = 1 + static_cast<double>(rounds[i].links) * 1e-5;
  }
  const std::string text = ForecastText(rounds, 0.02, 0);
  EXPECT_EQ(text.find("4.1 % → 2 %: about "), 0u) << text;
  EXPECT_NE(text.find(" M links"), std::string::npos) << text;
  EXPECT_NE(text.find(" s, "), std::string::npos) << text;
  EXPECT_NE(ForecastText(rounds, 0.02, 1e9).find("about 1 s"), std::string::npos);
  EXPECT_NE(ForecastText(rounds, 0.05, 0).find("to gather"), std::string::npos);
}

TEST(JobTextTest, WhatIsNotKnownYetIsNull) {
  JobInfo job;
  job.id = 3;
  nlohmann::json json = ToJson(job);
  EXPECT_EQ(json["state"], "queued");
  EXPECT_TRUE(json["error_estimate"].is_null());
  EXPECT_TRUE(json["end_reason"].is_null());
  EXPECT_EQ(json["rounds"], 0);

  job.state = JobState::kDone;
  job.summary.rounds.resize(2);
  job.summary.rounds[0].rays = 5;
  job.summary.rounds[1].rays = 6;
  job.summary.rounds[1].error_estimate = 0.01;
  json = ToJson(job);
  EXPECT_EQ(json["rays"], 11);
  EXPECT_EQ(json["error_estimate"], 0.01);
  ASSERT_EQ(json["history"].size(), 2u);
  EXPECT_EQ(json["history"][1]["error_estimate"], 0.01);
  EXPECT_EQ(json["end_reason"], "accuracy reached");
}

TEST(JobTextTest, SaysWhereTheOutputShowsMoreThanTheRounds) {
  JobInfo job;
  job.state = JobState::kDone;
  job.options.accuracy = 0.05;
  job.summary.rounds.resize(1);
  RoundSummary& last = job.summary.rounds.back();
  last.error_estimate = 0.04;
  EXPECT_EQ(Summarize(job).find("with the output gathered"), std::string::npos);
  last.error_estimate = 0.08;
  last.error_unseen = 0.07;
  EXPECT_NE(Summarize(job).find("error 8.00 % with the output gathered"), std::string::npos);
  EXPECT_NE(Describe(job).find("in doubt"), std::string::npos);
  EXPECT_EQ(ToJson(job)["doubts"].size(), 1u);
}

TEST(JobTextTest, AFailureSaysWhy) {
  JobInfo job;
  job.id = 3;
  job.state = JobState::kFailed;
  job.error = Status(StatusCode::kInternal, "the crowns differ");
  EXPECT_NE(Summarize(job).find("job 3 failed: the crowns differ"), std::string::npos);
  EXPECT_NE(Describe(job).find("the crowns differ"), std::string::npos);
  EXPECT_EQ(ToJson(job)["message"], "the crowns differ");
}

}  // namespace
}  // namespace isolux
