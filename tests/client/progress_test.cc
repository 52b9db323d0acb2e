#include "client/progress.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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
  EXPECT_EQ(json["end_reason"], "accuracy reached");
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
