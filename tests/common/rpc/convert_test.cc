#include "common/rpc/convert.h"

#include <gtest/gtest.h>

#include <random>

namespace isolux {
namespace {

// Every number different from every other, so that a mix-up shows.
RoundSummary Numbered(double base) {
  double next = base;
  RoundSummary round;
  round.round = static_cast<uint32_t>(++next);
  for (double* value : {&round.epsilon,
                        &round.error_estimate,
                        &round.error_spread,
                        &round.error_visibility,
                        &round.error_coupling,
                        &round.error_solver,
                        &round.residual,
                        &round.energy_imbalance,
                        &round.seconds,
                        &round.refine_s,
                        &round.exchange_s,
                        &round.solve_s,
                        &round.snapshot_s,
                        &round.balance_s,
                        &round.load_max_over_mean,
                        &round.error_closure,
                        &round.error_gather,
                        &round.error_rms,
                        &round.error_p95,
                        &round.error_worst,
                        &round.output_s,
                        &round.sample_s,
                        &round.links_per_split,
                        &round.leak_area,
                        &round.error_interpolation,
                        &round.error_unseen}) {
    *value = ++next;
  }
  for (uint64_t* value :
       {&round.elements, &round.links, &round.evaluations, &round.proved_visible,
        &round.proved_hidden, &round.rays, &round.bytes_in, &round.bytes_out, &round.migrated_nodes,
        &round.migrated_links, &round.memory_bytes, &round.worst_path, &round.output_elements,
        &round.output_points, &round.output_rays, &round.leaks}) {
    *value = static_cast<uint64_t>(++next);
  }
  for (uint32_t* value :
       {&round.iterations, &round.worst_polygon, &round.worst_surface, &round.unseen_polygon}) {
    *value = static_cast<uint32_t>(++next);
  }
  for (auto* power :
       {&round.emitted_w, &round.absorbed_w, &round.escaped_w, &round.medium_w, &round.glass_w}) {
    for (double& channel : *power) channel = ++next;
  }
  round.worker_cpu_s = {++next, ++next};
  round.costs["sky"] = {++next, 5, 6};
  round.measured = {{"clear-glass", ++next, ++next, ++next, true},
                    {"sheets", ++next, 1, {}, false}};
  return round;
}

TEST(ConvertTest, ARoundComesBackWhole) {
  const std::string bytes = ToProto(Numbered(0.5)).SerializeAsString();
  v1::RoundSummary message;
  ASSERT_TRUE(message.ParseFromString(bytes));
  const auto back = FromProto(message);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(ToProto(*back).SerializeAsString(), bytes);
  EXPECT_EQ(back->memory_bytes, Numbered(0.5).memory_bytes);
  EXPECT_EQ(back->escaped_w, Numbered(0.5).escaped_w);
  EXPECT_EQ(back->medium_w, Numbered(0.5).medium_w);
  EXPECT_EQ(back->glass_w, Numbered(0.5).glass_w);
  EXPECT_EQ(back->worker_cpu_s, Numbered(0.5).worker_cpu_s);
  EXPECT_EQ(back->measured, Numbered(0.5).measured);
  EXPECT_EQ(back->costs, Numbered(0.5).costs);
}

JobInfo Job() {
  JobInfo job;
  job.id = 7;
  job.name = "Küche.obj";
  job.request_id = "abc";
  job.state = JobState::kRunning;
  job.options.accuracy = 0.125;
  job.options.epsilons = {2, 1};
  job.options.solver = SolverMethod::kChebyshev;
  job.options.effects = "all,-closure";
  job.digest = std::string(32, 'd');
  job.scene_bytes = 11;
  job.polygons = 12;
  job.repairs.entries = {{"duplicates dropped", 3, "a.obj:9"}};
  job.submitted_ms = 13;
  job.started_ms = 14;
  job.summary.rounds = {Numbered(1), Numbered(100)};
  job.summary.end_reason = EndReason::kMemory;
  job.summary.seconds = 15;
  job.summary.gather_s = 16;
  job.summary.workers = 17;
  job.summary.rays = 18;
  job.activity = {"solving", 2, 17, 1.5};
  job.finishing = true;
  return job;
}

TEST(ConvertTest, AJobComesBackWhole) {
  const v1::Job message = ToProto(Job(), /*whole=*/true);
  const auto back = FromProto(message);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(ToProto(*back, true).SerializeAsString(), message.SerializeAsString());
  EXPECT_EQ(back->name, "Küche.obj");
  EXPECT_EQ(back->summary.end_reason, EndReason::kMemory);
  EXPECT_EQ(back->activity, Job().activity);
  EXPECT_TRUE(back->error.ok());
  const v1::Job part = ToProto(Job(), /*whole=*/false);
  EXPECT_EQ(part.rounds_size(), 0);
  EXPECT_EQ(part.repairs_size(), 0);
}

TEST(ConvertTest, AFailureKeepsItsCodeAndReason) {
  JobInfo job = Job();
  job.state = JobState::kFailed;
  job.error = Status(StatusCode::kAborted, "the workers were lost");
  const auto back = FromProto(ToProto(job, true));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->error.code(), StatusCode::kAborted);
  EXPECT_EQ(back->error.message(), "the workers were lost");
}

TEST(ConvertTest, WhatNoStructHoldsIsRefused) {
  v1::Job job = ToProto(Job(), true);
  job.set_state(static_cast<v1::JobState>(99));
  EXPECT_FALSE(FromProto(job).has_value());
  job = ToProto(Job(), true);
  job.set_end_reason(v1::END_REASON_UNSPECIFIED);
  EXPECT_FALSE(FromProto(job).has_value());
  v1::RoundSummary round = ToProto(Numbered(1));
  round.add_emitted_w(4);
  EXPECT_FALSE(FromProto(round).has_value());
  google::protobuf::RepeatedPtrField<v1::Repair> repairs;
  for (int i = 0; i <= kMaxRepairs; ++i) repairs.Add();
  EXPECT_FALSE(TakeRepairs(repairs).has_value());
}

TEST(ConvertTest, TextIsMadeUtf8) {
  EXPECT_EQ(Utf8("Küche – 室 🙂"), "Küche – 室 🙂");
  EXPECT_EQ(Utf8("a\xff"
                 "b"),
            "a?b");
  EXPECT_EQ(Utf8("\xc3"), "?");
  EXPECT_EQ(Utf8("\xed\xa0\x80"), "???") << "a surrogate";
  EXPECT_EQ(Utf8("\xc0\x80"), "??") << "longer than needed";
  EXPECT_LE(Utf8(std::string(10'000, 'x')).size(), size_t{kMaxTextBytes});
  for (uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::string text(random() % 40, '\0');
    for (char& c : text) c = static_cast<char>(random() % 4 == 0 ? 'a' : random());
    v1::Job job;
    job.set_name(Utf8(text));
    v1::Job back;
    EXPECT_TRUE(back.ParseFromString(job.SerializeAsString()));
    EXPECT_EQ(Utf8(job.name()), job.name()) << "what is UTF-8 stays as it is";
  }
}

TEST(ConvertTest, AFrameComesBackWhole) {
  FrameData frame{
      .epoch = 1, .sequence = 2, .kind = 3, .last = true, .data = "data", .message_bytes = 4};
  const FrameData back = FromProto(ToProto(frame));
  EXPECT_EQ(back.epoch, 1u);
  EXPECT_EQ(back.sequence, 2u);
  EXPECT_EQ(back.kind, 3u);
  EXPECT_TRUE(back.last);
  EXPECT_EQ(back.data, "data");
  EXPECT_EQ(back.message_bytes, 4u);
}

}  // namespace
}  // namespace isolux
