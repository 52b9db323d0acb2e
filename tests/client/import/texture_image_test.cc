#include "client/import/texture_image.h"

#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <vector>

#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using testing::TempDir;

// Left half of one colour, right half of another.
std::vector<uint8_t> Halves(int size, const std::array<uint8_t, 3>& a,
                            const std::array<uint8_t, 3>& b) {
  std::vector<uint8_t> pixels;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const auto& colour = x < size / 2 ? a : b;
      pixels.insert(pixels.end(), colour.begin(), colour.end());
    }
  }
  return pixels;
}

Result<Rgb> LinearMean(const std::string& path, uint64_t most_pixels = 1 << 20) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  ASSIGN_OR_RETURN(const LinearImage image,
                   DecodeImage(bytes, path, Encoding::kSrgb, 512, most_pixels));
  return image.Mean();
}

TEST(FromSrgb, MeetsTheStandardsPoints) {
  EXPECT_EQ(FromSrgb(0), 0);
  EXPECT_NEAR(FromSrgb(1), 1, 1e-15);
  EXPECT_NEAR(FromSrgb(0.04045), 0.0031308, 1e-7);
  EXPECT_NEAR(FromSrgb(0.5), 0.21404114, 1e-8);
}

TEST(LinearMean, AveragesLightAndNotCodes) {
  const TempDir dir;
  const std::string path = dir.path() + "/halves.png";
  const auto pixels = Halves(8, {255, 0, 188}, {0, 0, 188});
  ASSERT_NE(stbi_write_png(path.c_str(), 8, 8, 3, pixels.data(), 24), 0);
  const Result<Rgb> mean = LinearMean(path);
  ASSERT_TRUE(mean.has_value()) << mean.error().message();
  EXPECT_NEAR(mean->x, 0.5, 1e-12);
  EXPECT_EQ(mean->y, 0);
  EXPECT_NEAR(mean->z, FromSrgb(188 / 255.0), 1e-12);
}

TEST(LinearMean, ReadsJpegAndGrey) {
  const TempDir dir;
  const std::string jpeg = dir.path() + "/flat.jpg";
  const auto pixels = Halves(16, {200, 100, 50}, {200, 100, 50});
  ASSERT_NE(stbi_write_jpg(jpeg.c_str(), 16, 16, 3, pixels.data(), 95), 0);
  const Result<Rgb> mean = LinearMean(jpeg);
  ASSERT_TRUE(mean.has_value()) << mean.error().message();
  EXPECT_NEAR(mean->x, FromSrgb(200 / 255.0), 0.02);
  EXPECT_NEAR(mean->y, FromSrgb(100 / 255.0), 0.02);

  const std::string grey = dir.path() + "/grey.png";
  const std::vector<uint8_t> values(64, 128);
  ASSERT_NE(stbi_write_png(grey.c_str(), 8, 8, 1, values.data(), 8), 0);
  const Result<Rgb> grey_mean = LinearMean(grey);
  ASSERT_TRUE(grey_mean.has_value());
  EXPECT_NEAR(grey_mean->y, FromSrgb(128 / 255.0), 1e-12);
  EXPECT_EQ(grey_mean->x, grey_mean->z);
}

TEST(LinearMean, RefusesWhatIsNoImageOrTooLarge) {
  const TempDir dir;
  EXPECT_EQ(LinearMean(dir.path() + "/none.png").error().code(), StatusCode::kNotFound);
  EXPECT_EQ(LinearMean(dir.path()).error().code(), StatusCode::kInvalidArgument);
  EXPECT_FALSE(LinearMean(dir.Write("text.png", "no image")).has_value());
  EXPECT_FALSE(LinearMean(dir.Write("empty.png", "")).has_value());
  const std::string path = dir.path() + "/image.png";
  const auto pixels = Halves(8, {1, 2, 3}, {4, 5, 6});
  ASSERT_NE(stbi_write_png(path.c_str(), 8, 8, 3, pixels.data(), 24), 0);
  EXPECT_EQ(LinearMean(path, 63).error().code(), StatusCode::kResourceExhausted);
  EXPECT_TRUE(LinearMean(path, 64).has_value());
}

}  // namespace
}  // namespace isolux
