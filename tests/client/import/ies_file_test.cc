// Photometric files: what they say, and what is said of damaged ones.
#include "client/import/ies_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "client/import/import.h"
#include "common/util/random.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Even intensities of 50 cd below, 0 above; the flux of half a sphere, 100π lm.
constexpr char kEven[] =
    "IESNA:LM-63-2002\r\n[TEST] none\r\n[MANUFAC] nobody\r\nTILT=NONE\r\n"
    "1 1000 25 3 1 1 2 0.1 0.1 0\r\n1 1 40\r\n0 45, 90\r\n0\r\n2 2\r\n2\r\n";

std::string ErrorOf(const std::string& text) {
  const Result<Photometry> table = ParseIes(text, "lamp.ies");
  EXPECT_FALSE(table.has_value()) << text;
  return table.has_value() ? "" : table.error().message();
}

std::string With(const std::string& from, const std::string& to) {
  std::string text = kEven;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(IesFile, ReadsTablesWhereverLinesEnd) {
  const Result<Photometry> table = ParseIes(kEven, "lamp.ies");
  ASSERT_TRUE(table.has_value()) << table.error().message();
  EXPECT_THAT(table->from_axis, ElementsAre(0, 45, 90));
  EXPECT_THAT(table->around, ElementsAre(0));
  EXPECT_THAT(table->intensity, ElementsAre(50, 50, 50));
  EXPECT_NEAR(table->Power(), 100 * std::numbers::pi, 1e-9);
  EXPECT_EQ(table->Towards({0, 0, 1}, {0, 0, -1}, {1, 0, 0}), 0);
  EXPECT_EQ(table->Towards({0.6, 0, -0.8}, {0, 0, -1}, {1, 0, 0}), 50);
}

TEST(IesFile, FactorsMultiply) {
  const Result<Photometry> table = ParseIes(With("1 1 40", "0.5 0.8 40"), "lamp.ies");
  ASSERT_TRUE(table.has_value());
  EXPECT_NEAR(table->intensity[0], 20, 1e-6);
  EXPECT_NEAR(ParseIes(With("1 1 40", "1 0 40"), "lamp.ies")->intensity[0], 50, 1e-6);
}

TEST(IesFile, TiltIsSkipped) {
  const auto table = ParseIes(With("TILT=NONE", "TILT=INCLUDE\r\n1\r\n2\r\n0 90\r\n1 0.9"), "a");
  ASSERT_TRUE(table.has_value()) << table.error().message();
  EXPECT_EQ(table->intensity[2], 50);
  EXPECT_THAT(ErrorOf(With("TILT=NONE", "TILT=other.tlt")), HasSubstr("is not read"));
}

TEST(IesFile, NamesFileAndLine) {
  EXPECT_THAT(ErrorOf("nothing\n"), HasSubstr("lamp.ies:2: no line 'TILT=…'"));
  EXPECT_THAT(ErrorOf(With("0 45, 90", "0 forty 90")),
              HasSubstr("lamp.ies:7: 'forty' is no number, where a vertical angle should stand"));
  EXPECT_THAT(ErrorOf(With("3 1 1 2", "3 1 2 2")), HasSubstr("lamp.ies:5: photometry of type B"));
  EXPECT_THAT(ErrorOf(With("3 1 1 2", "1e9 1 1 2")), HasSubstr("number of vertical angles"));
  EXPECT_THAT(ErrorOf(With("2 2\r\n2", "2 2")), HasSubstr("the file ends before an intensity"));
  EXPECT_THAT(ErrorOf(With("0 45, 90", "0 90 45")), HasSubstr("do not ascend"));
  EXPECT_THAT(ErrorOf(With("2 2\r\n2", "2 -2\r\n2")), HasSubstr("negative"));
  EXPECT_THAT(ErrorOf(With("90\r\n0\r\n", "90\r\n10\r\n")), HasSubstr("horizontal angles"));
}

TEST(IesFile, DamagedFilesAreReadOrRefused) {
  Random random(5);
  for (int i = 0; i < 5000; ++i) {
    std::string text = kEven;
    for (int k = 0; k < 2; ++k) {
      const size_t at = random.Bits() % text.size();
      if (random.Bits() % 2 == 0) {
        text.erase(at, 1 + random.Bits() % 6);
      } else {
        text[at] = static_cast<char>(random.Bits() % 256);
      }
    }
    const Result<Photometry> table = ParseIes(text, "lamp.ies");
    if (table.has_value()) {
      EXPECT_TRUE(CheckPhotometry(*table).ok());
      EXPECT_GE(table->Power(), -1e-6 * table->Largest());
    } else {
      EXPECT_THAT(table.error().message(), HasSubstr("lamp.ies:"));
    }
  }
}

TEST(IesFile, StandsBesideAScene) {
  const testing::TempDir dir;
  dir.Write("lamp.ies", kEven);
  dir.Write("isolux.json", R"({"lights": [
    {"type": "ies", "file": "lamp.ies", "position": [0, 0, 2], "direction": [0, 0, -1]},
    {"type": "ies", "file": "lamp.ies", "position": [1, 0, 2], "direction": [0, 0, -1],
     "ahead": [0, 1, 0], "colour": [1, 0.9, 0.8]}]})");
  const std::string path = dir.Write("s.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  const Result<Scene> scene = ImportScene(path, {});
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(scene->photometries.size(), 1U);
  ASSERT_EQ(scene->lights.size(), 2U);
  EXPECT_EQ(scene->lights[1].ahead, Vec3(0, 1, 0));
  const Result<Scene> back = Decode(Encode(*scene));
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->photometries, scene->photometries);
  EXPECT_EQ(back->lights, scene->lights);
  const std::string bytes = Encode(*scene);
  for (size_t length = bytes.size() - 300; length < bytes.size(); ++length) {
    EXPECT_FALSE(Decode(bytes.substr(0, length)).has_value());
  }
}

}  // namespace
}  // namespace isolux
