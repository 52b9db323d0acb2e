#include "client/report/report.h"

#include <gtest/gtest.h>

#include "tests/client/output/patches.h"

namespace isolux {
namespace {

using nlohmann::json;

PatchFile SolvedRoom() {
  PatchFile file = testing::RoomPatches(true);
  for (size_t i = 0; i < file.faces.size(); ++i)
    file.faces[i].error = 0.01F * static_cast<float>(i);
  file.comments = {{"scene", "room.obj"},
                   {"accuracy", "0.05"},
                   {"seconds", "1.5"},
                   {"round", "1 epsilon 0.5 error 0.1 seconds 1 cpu_s 0.5,0.4"}};
  return file;
}

// With small pictures.
Result<json> DataOf(const PatchFile& file, ReportOptions options = {}) {
  options.picture_side = 48;
  ThreadPool pool(1);
  return MakeReportData(file, options, pool);
}

TEST(Report, HoldsCommentsPicturesAndTheWorstPolygons) {
  ReportOptions options;
  options.name = "other.ply";
  options.job = {{"job", 7}};
  const auto data = DataOf(SolvedRoom(), options);
  ASSERT_TRUE(data.has_value()) << data.error().message();
  EXPECT_EQ((*data)["name"], "room.obj");
  EXPECT_EQ((*data)["job"]["job"], 7);
  EXPECT_EQ((*data)["summary"]["seconds"], 1.5);
  EXPECT_EQ((*data)["rounds"].size(), 1u);
  const json& pictures = (*data)["pictures"];
  for (const char* which : {"solution", "error"}) {
    EXPECT_TRUE(pictures[which].get<std::string>().starts_with("data:image/png;base64,iVBOR"));
  }
  EXPECT_NE(pictures["solution"], pictures["error"]);
  EXPECT_EQ(std::max(pictures["width"].get<int>(), pictures["height"].get<int>()), 48);
  EXPECT_DOUBLE_EQ(pictures["low"], 0.005);
  EXPECT_DOUBLE_EQ(pictures["high"], 0.5);
  const json& worst = (*data)["faces"]["worst_polygons"];
  // Polygons 0 to 4 with errors 0, 1, 2, 3, 4 % over areas 7.5, 7.5, 18, 18, 15: the first has
  // none.
  ASSERT_EQ(worst.size(), 4u);
  EXPECT_EQ(worst[0]["polygon"], 4);
  EXPECT_NEAR(worst[0]["share"], 0.6 / 1.575, 1e-6);
  EXPECT_NEAR(worst[1]["share"], 0.54 / 1.575, 1e-6);
  EXPECT_NEAR((*data)["faces"]["error_mean"], 1.575 / 66, 1e-6);
}

TEST(Report, TakesTheNameOfTheFileWhereTheSceneHasNone) {
  PatchFile file = SolvedRoom();
  file.comments.erase(file.comments.begin());
  ReportOptions options;
  options.name = "a.ply";
  EXPECT_EQ((*DataOf(file, options))["name"], "a.ply");
}

TEST(Report, IsTheSameForTheSameFile) {
  EXPECT_EQ(*DataOf(SolvedRoom()), *DataOf(SolvedRoom()));
  ReportOptions elsewhere;
  elsewhere.camera = Camera();
  elsewhere.camera->eye = Vec3(3, 1, 2.5);
  elsewhere.camera->target = Vec3(1, 1, 1);
  EXPECT_NE((*DataOf(SolvedRoom(), elsewhere))["pictures"], (*DataOf(SolvedRoom()))["pictures"]);
}

TEST(Report, RefusesWhatTellsNothing) {
  PatchFile file = SolvedRoom();
  file.comments.pop_back();
  auto data = DataOf(file);
  ASSERT_FALSE(data.has_value());
  EXPECT_EQ(data.error().code(), StatusCode::kInvalidArgument);
  EXPECT_NE(data.error().message().find("no rounds"), std::string::npos) << data.error().message();
  file = SolvedRoom();
  file.faces.clear();
  data = DataOf(file);
  ASSERT_FALSE(data.has_value());
  EXPECT_NE(data.error().message().find("no faces"), std::string::npos) << data.error().message();
}

TEST(Report, IsOnePage) {
  ThreadPool pool(1);
  ReportOptions options;
  options.picture_side = 16;
  const auto page = MakeReport(SolvedRoom(), options, pool);
  ASSERT_TRUE(page.has_value());
  EXPECT_NE(page->find("<title>room.obj: report</title>"), std::string::npos);
  EXPECT_NE(page->find("data-page=\"report\""), std::string::npos);
}

}  // namespace
}  // namespace isolux
