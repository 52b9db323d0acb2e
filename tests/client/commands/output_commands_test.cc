// render and compare as a user calls them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "client/commands/commands.h"
#include "tests/client/output/patches.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

class OutputCommands : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("isolux_output_commands_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
    PatchFile room = testing::RoomPatches(true);
    room.comments = {{"scene_hash", "aa"}};
    ASSERT_TRUE(WritePatchFile(room, Path("room.ply")).ok());
    room.comments = {{"scene_hash", "bb"}};
    ASSERT_TRUE(WritePatchFile(room, Path("other.ply")).ok());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  // The exit code; what was printed is in out_ and err_.
  int Call(const std::vector<std::string>& words) {
    CLI::App app;
    isolux::Run run;
    AddRenderCommand(app, run);
    AddCompareCommand(app, run);
    try {
      app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError&) {
      return 2;
    }
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = run();
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  std::filesystem::path folder_;
  std::string out_, err_;
};

TEST_F(OutputCommands, RenderWritesPictures) {
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("a.PNG"), "--width", "40", "--samples",
                  "2", "--threads", "1"}),
            0);
  EXPECT_EQ(out_, "");
  EXPECT_TRUE(std::filesystem::exists(Path("a.PNG")));
  std::ofstream(Path("cam.json")) << R"({"eye": [3, 1.2, 8], "target": [3, 1.2, 0]})";
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("b.exr"), "--camera", Path("cam.json"),
                  "--width", "16", "--height", "16", "--samples", "1"}),
            0);
  EXPECT_THAT(err_, HasSubstr("16 × 16 pixels"));
}

TEST_F(OutputCommands, RenderSaysWhatIsWrong) {
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("a.jpg")}), 2);
  EXPECT_THAT(err_, HasSubstr(".png or .exr"));
  EXPECT_EQ(Call({"render", Path("absent.ply"), "-o", Path("a.png")}), 2);
  EXPECT_THAT(err_, HasSubstr("absent.ply"));
  std::ofstream(Path("cam.json")) << R"({"eye": [3, 1.2, 8]})";
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("a.png"), "--camera", Path("cam.json")}),
            2);
  EXPECT_THAT(err_, HasSubstr("cam.json: \"target\""));
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("a.png"), "--tone-map", "none"}), 2);
  EXPECT_EQ(Call({"render", Path("room.ply")}), 2);
  EXPECT_EQ(Call({"render", Path("room.ply"), "-o", Path("no/a.png"), "--width", "4"}), 1);
  ASSERT_TRUE(WritePatchFile({}, Path("empty.ply")).ok());
  EXPECT_EQ(Call({"render", Path("empty.ply"), "-o", Path("a.png")}), 2);
  EXPECT_THAT(err_, HasSubstr("no faces"));
  EXPECT_FALSE(std::filesystem::exists(Path("a.png")));
}

TEST_F(OutputCommands, ComparePrintsTheKeysAsked) {
  EXPECT_EQ(Call({"compare", Path("room.ply"), Path("room.ply"), "--json", "--samples", "1000"}),
            0);
  for (const char* key :
       {"\"l1_relative\":", "\"rms_relative\":", "\"max_relative\":", "\"samples\":1000"}) {
    EXPECT_THAT(out_, HasSubstr(key));
  }
  EXPECT_EQ(Call({"compare", Path("room.ply"), Path("room.ply"), "--samples", "1000"}), 0);
  EXPECT_THAT(out_, HasSubstr("mean difference        0.000 %"));
}

TEST_F(OutputCommands, CompareRefusesDifferentScenes) {
  EXPECT_EQ(Call({"compare", Path("room.ply"), Path("other.ply")}), 2);
  EXPECT_THAT(err_, HasSubstr("--force"));
  EXPECT_EQ(out_, "");
  EXPECT_EQ(Call({"compare", Path("room.ply"), Path("other.ply"), "--force"}), 0);
}

}  // namespace
}  // namespace isolux
