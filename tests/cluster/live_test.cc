// What a user can do with a job while it runs: look at its newest round, and end it there.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "common/scene/patch_file.h"
#include "common/util/file.h"
#include "tests/support/processes.h"

namespace isolux::testing {
namespace {

const std::string kScene = ScenePath("cornell_box/cornell_box.obj");

// A job that would take very long.
CommandResult SubmitLong(Programs& programs) {
  return programs.Isolux({"submit", kScene, "--unit", "mm", "--accuracy", "0.001"});
}

PatchFile Read(const std::string& path) {
  const auto bytes = ReadFile(path);
  EXPECT_TRUE(bytes.has_value());
  auto patch = DecodePatchFile(bytes.value_or(""), path);
  EXPECT_TRUE(patch.has_value()) << patch.error().message();
  return patch.value_or(PatchFile());
}

TEST(LiveTest, BeforeTheFirstRoundThereIsNothing) {
  Programs programs;
  programs.StartServer();  // and no worker
  ASSERT_EQ(SubmitLong(programs).code, 0);
  const std::string path = programs.Path("early.ply");
  const CommandResult fetched = programs.Isolux({"fetch", "1", "--latest", "-o", path});
  EXPECT_EQ(fetched.code, 1);
  EXPECT_NE(fetched.error.find("first round"), std::string::npos) << fetched.error;
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  // A job behind it is queued.
  ASSERT_EQ(SubmitLong(programs).code, 0);
  const CommandResult queued = programs.Isolux({"finish", "2"});
  EXPECT_EQ(queued.code, 1);
  EXPECT_NE(queued.error.find("queued"), std::string::npos) << queued.error;
  EXPECT_EQ(programs.Isolux({"cancel", "2"}).code, 0);
  EXPECT_EQ(programs.Isolux({"finish", "2"}).code, 1) << "it was cancelled";
  const CommandResult unknown = programs.Isolux({"finish", "77"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.error.find("no job 77"), std::string::npos) << unknown.error;
  EXPECT_EQ(programs.Isolux({"fetch", "77", "--latest", "-o", path}).code, 2);
}

TEST(LiveTest, TheNewestRoundIsFetchedAndTheJobFinished) {
  Programs programs;
  programs.StartServer();
  programs.StartWorker();
  ASSERT_EQ(SubmitLong(programs).code, 0);
  programs.WaitForRounds(1, 2);
  const std::string latest = programs.Path("latest.ply"), result = programs.Path("result.ply");
  const CommandResult fetched = programs.Isolux({"fetch", "1", "--latest", "-o", latest});
  ASSERT_EQ(fetched.code, 0) << fetched.error;
  const PatchFile patch = Read(latest);
  EXPECT_GE(std::stoi(patch.Comment("latest_round")), 2);
  EXPECT_EQ(patch.Comment("rounds"), patch.Comment("latest_round"));
  EXPECT_NE(patch.Comment("end_reason").find("not ended"), std::string::npos);
  EXPECT_NE(patch.Comment("gathered").find("no"), std::string::npos);
  EXPECT_GE(std::stod(patch.Comment("error_estimate")),
            std::stod(patch.Comment("error_estimate_gathered")));
  EXPECT_GT(patch.faces.size(), 100u);
  double worst = 0;
  for (const PatchFace& face : patch.faces) worst = std::max<double>(worst, face.error);
  EXPECT_GT(worst, 0);

  const CommandResult finished = programs.Isolux({"finish", "1"});
  EXPECT_EQ(finished.code, 0) << finished.error;
  EXPECT_EQ(finished.output, "job 1 done\n");
  ASSERT_EQ(programs.Isolux({"fetch", "1", "-o", result}).code, 0);
  const PatchFile whole = Read(result);
  EXPECT_EQ(whole.Comment("end_reason"), ToText(EndReason::kFinished));
  EXPECT_EQ(whole.Comment("scene_hash"), patch.Comment("scene_hash"));
  // Of a job that is done, all of it.
  EXPECT_EQ(programs.Isolux({"finish", "1", "--json"}).Json()["state"], "done");
  ASSERT_EQ(programs.Isolux({"fetch", "1", "--latest", "-o", latest}).code, 0);
  EXPECT_EQ(*ReadFile(latest), *ReadFile(result));

  // Nobody who looked has changed a bit.
  std::string epsilons = whole.Comment("epsilons");
  std::replace(epsilons.begin(), epsilons.end(), ' ', ',');
  const std::string again = programs.Path("again.ply");
  const CommandResult replayed =
      programs.Isolux({"submit", kScene, "--unit", "mm", "--accuracy", "0.001", "--epsilons",
                       epsilons, "--wait", "-o", again});
  ASSERT_EQ(replayed.code, 0) << replayed.error;
  EXPECT_TRUE(Physics(again) == Physics(result));
}

}  // namespace
}  // namespace isolux::testing
