#include "client/output/reference_points.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

class ReferencePoints : public ::testing::Test {
 protected:
  std::string Write(const std::string& text) {
    std::ofstream(path_) << text;
    return path_;
  }
  std::string ErrorOf(const std::string& text) {
    const auto points = ReadReferencePoints(Write(text));
    return points ? "" : points.error().message();
  }

  testing::TempDir folder_;
  const std::string path_ = folder_.path() + "/points.csv";
};

TEST_F(ReferencePoints, KeepTheirBits) {
  const std::vector<ReferencePoint> points = {
      {{0.1, -1e-17, 1.0 / 3}, {0, 0.6, 0.8}, {12.5, 0, 1e-9}, {0.1, 0.2, 0.3}},
      {{1e6, 2, 3}, {-1, 0, 0}, {1, 2, 3}, {0, 0, 0}}};
  ASSERT_TRUE(WriteReferencePoints(points, path_).ok());
  const auto read = ReadReferencePoints(path_);
  ASSERT_TRUE(read.has_value()) << read.error().message();
  ASSERT_EQ(read->size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].position, points[i].position);
    EXPECT_EQ((*read)[i].irradiance, points[i].irradiance);
    EXPECT_EQ((*read)[i].deviation, points[i].deviation);
    EXPECT_NEAR(glm::length((*read)[i].normal - points[i].normal), 0, 1e-15);
  }
}

TEST_F(ReferencePoints, MayEndInACommaAndHaveEmptyLines) {
  const auto read =
      ReadReferencePoints(Write("0,0,0,0,0,2,1,1,1,0,0,0,\r\n\n1,0,0,0,0,1,1,1,1,0,0,0"));
  ASSERT_TRUE(read.has_value()) << read.error().message();
  EXPECT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].normal, Vec3(0, 0, 1));
}

TEST_F(ReferencePoints, ErrorsNameTheFileAndTheLine) {
  const std::string good = "0,0,0,0,0,1,1,1,1,0,0,0\n";
  for (const char* bad : {"0,0,0,0,0,1,1,1,1,0,0\n", "0,0,0,0,0,1,1,1,1,0,0,0,0\n",
                          "0,0,0,0,0,1,nan,1,1,0,0,0\n", "0 0 0 0 0 1 1 1 1 0 0 0\n", "x\n",
                          "0,0,0,0,0,0,1,1,1,0,0,0\n", "0,0,0,0,0,1,-1,1,1,0,0,0\n"}) {
    EXPECT_NE(ErrorOf(good + bad + good).find(path_ + ":2: "), std::string::npos)
        << bad << ErrorOf(good + bad + good);
  }
  EXPECT_NE(ErrorOf("").find(path_), std::string::npos);
  EXPECT_NE(ErrorOf("ply\nformat").find("twelve numbers"), std::string::npos);
  EXPECT_FALSE(ReadReferencePoints(folder_.path() + "/absent.csv").has_value());
}

}  // namespace
}  // namespace isolux
