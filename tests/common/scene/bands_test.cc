// Spectral bands of a scene: which channel they are part of, groups of three, and as bytes.
#include "common/scene/bands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/scene.h"
#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

// Four: one blue, two green of unlike width, one red.
Scene FourBands() {
  Scene scene = testing::FurnaceCube(0.5, 1);
  scene.bands = {{400, 490}, {490, 510}, {510, 570}, {600, 700}};
  scene.materials[0].spectrum = {{.1, .2, .3, .4}, {.5, .4, .3, .2}, {}};
  scene.materials[3].spectrum.reradiation = {
      4, {0, .1, .2, .05, 0, 0, 0, .3, 0, 0, 0, .15, 0, 0, 0, 0}};
  scene.materials[2].spectrum.exitance = {1, 2, 3, 4};
  return scene;
}

TEST(Bands, BelongToAChannelByTheirMiddle) {
  EXPECT_EQ((Band{480, 499}.channel()), 2);
  EXPECT_EQ((Band{480, 500}.channel()), 1);
  EXPECT_EQ((Band{570, 589}.channel()), 1);
  EXPECT_EQ((Band{570, 590}.channel()), 0);
  const std::vector<Band> bands = FourBands().bands;
  EXPECT_EQ(ShareOfChannel(bands, 0), 1);
  EXPECT_EQ(ShareOfChannel(bands, 1), 0.25);
  EXPECT_EQ(ShareOfChannel(bands, 2), 0.75);
  const std::vector<double> values = {1, 2, 6, 7};
  EXPECT_EQ(MeanOfChannel(bands, values, 1, 0), 5);
  EXPECT_EQ(SumOfChannel(bands, values, 1), 8);
  const std::vector<Band> blue = {{400, 450}};
  EXPECT_FALSE(HasBands(blue, 0));
  EXPECT_EQ(MeanOfChannel(blue, std::vector<double>{3}, 0, 9), 9);
}

TEST(Bands, MakeGroupsOfThree) {
  EXPECT_EQ(BandGroupCount(3), 1U);
  EXPECT_EQ(BandGroupCount(4), 2U);
  EXPECT_EQ(BandInChannel(4, 0, 2), 0U);
  EXPECT_EQ(BandInChannel(4, 0, 0), 2U);
  EXPECT_EQ(BandInChannel(4, 1, 2), 3U);
  EXPECT_EQ(BandInChannel(4, 1, 1), kMostBands);
  Scene scene = FourBands();
  scene.materials[1].reflectance = {.7, .6, .5};
  scene.materials[1].exitance = {8, 4, 2};
  scene.materials[1].transmittance = {.03, .02, .01};
  scene.medium.extinction_per_m = {3, 2, 1};
  const Scene first = SceneOfGroup(scene, 0), second = SceneOfGroup(scene, 1);
  EXPECT_TRUE(first.bands.empty());
  EXPECT_EQ(first.materials[0].reflectance, Rgb(.3, .2, .1));
  EXPECT_EQ(first.materials[0].transmittance, Rgb(.3, .4, .5));
  EXPECT_EQ(first.materials[1].reflectance, Rgb(.6, .6, .5));
  EXPECT_EQ(first.materials[1].exitance, Rgb(3, 1, 2));
  EXPECT_EQ(first.materials[1].transmittance, Rgb(.02, .02, .01));
  EXPECT_EQ(first.materials[2].exitance, Rgb(3, 2, 1));
  EXPECT_EQ(first.medium.extinction_per_m, Rgb(2, 2, 1));
  // The last group has one band: it reflects alike in all channels, and the others are dark.
  EXPECT_EQ(second.materials[0].reflectance, Rgb(.4));
  EXPECT_EQ(second.materials[2].exitance, Rgb(0, 0, 4));
  EXPECT_EQ(second.materials[1].exitance, Rgb(0, 0, 8));
}

TEST(Bands, OfAGroupReradiateWithinIt) {
  Scene scene = FourBands();
  const Material first = MaterialOfGroup(scene, scene.materials[3], 0);
  EXPECT_EQ(first.reradiation, (Reradiation{.1, .2, 0}));
  EXPECT_FALSE(MaterialOfGroup(scene, scene.materials[3], 1).reradiation.exists());
  EXPECT_FALSE(MaterialOfGroup(scene, scene.materials[0], 0).reradiation.exists());
  EXPECT_FALSE(IsHandedLight(scene, 0));
  EXPECT_TRUE(IsHandedLight(scene, 1));
  BandReradiation& matrix = scene.materials[3].spectrum.reradiation;
  EXPECT_NEAR(matrix.Taken(0), .35, 1e-15);
  EXPECT_NEAR(matrix.LargestTaken(), .35, 1e-15);
  EXPECT_NEAR(GivenBack(scene, scene.materials[3], 0), .5 + .35, 1e-15);
  // Green, of two bands of 20 and 60 nm, to red.
  EXPECT_NEAR(matrix.BetweenChannels(scene.bands).green_to_red, (20 * .3 + 60 * .15) / 80, 1e-15);
  EXPECT_NEAR(matrix.BetweenChannels(scene.bands).blue_to_green, .3, 1e-15);
  EXPECT_EQ(matrix.WithinChannel(scene.bands, 1), 0);
  for (const size_t from : {0, 1, 2}) matrix.shares[4 * from + 3] = 0;
  EXPECT_FALSE(IsHandedLight(scene, 1));
}

TEST(Bands, TakeLightsSkyGlassAndTexturesWithThem) {
  Scene scene = FourBands();
  scene.lights.push_back({.name = "lamp", .intensity = {8, 4, 0}});
  scene.lights.push_back({.name = "blue", .intensity = {0, 0, 1}});
  scene.sky.columns = scene.sky.rows = 1;
  scene.sky.texels = {3, 4, 5};
  scene.glazing.glasses.push_back({{.1, .2, .3}, 1.5});
  scene.textures.push_back({1, 1, Wrap::kRepeat, Wrap::kRepeat, {.25F, .5F, .75F}});
  const Scene first = SceneOfGroup(scene, 0), second = SceneOfGroup(scene, 1);
  ASSERT_EQ(first.lights.size(), 2U);
  EXPECT_EQ(first.lights[0].intensity, Rgb(3, 1, 0));
  EXPECT_EQ(first.sky.texels, (std::vector<float>{3, 1, 5}));
  EXPECT_EQ(first.glazing.glasses[0].optical_depth, Rgb(.2, .2, .3));
  EXPECT_EQ(first.textures[0].texels, (std::vector<float>{.5F, .5F, .75F}));
  ASSERT_EQ(second.lights.size(), 1U);  // the blue one is dark in it
  EXPECT_EQ(second.lights[0].intensity, Rgb(0, 0, 8));
  scene.sky.texels = {0, 4, 5};
  EXPECT_FALSE(SceneOfGroup(scene, 1).sky.exists());
}

TEST(SceneBytes, BandsFollow) {
  const Scene scene = FourBands();
  ASSERT_TRUE(Validate(scene).ok()) << Validate(scene).message();
  const std::string bytes = Encode(scene);
  const auto back = Decode(bytes);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->bands, scene.bands);
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    EXPECT_EQ(back->materials[m].spectrum, scene.materials[m].spectrum);
  }
  EXPECT_EQ(Encode(*back), bytes);
  Scene plain = scene;
  plain.bands.clear();
  for (Material& material : plain.materials) material.spectrum = {};
  const std::string without = Encode(plain);
  EXPECT_EQ(without, bytes.substr(0, without.size()));
  for (size_t size = without.size() + 1; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode(bytes.substr(0, size)).has_value()) << size;
  }
}

TEST(SceneBytes, DamagedBandsGiveAnErrorOrAScene) {
  constexpr uint64_t kSeed = 20261130;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  const std::string good = Encode(FourBands());
  Random random(kSeed);
  int refused = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string bytes = good;
    // The last 400 bytes: bands and spectra, and some of what is before them.
    const size_t at = bytes.size() - 1 - random.Bits() % 400;
    if (random.Bits() % 4 == 0) {
      bytes.resize(at);
    } else {
      bytes[at] = static_cast<char>(random.Bits());
    }
    const auto scene = Decode(bytes);
    refused += scene.has_value() ? 0 : 1;
    if (scene.has_value() && Validate(*scene).ok()) {
      for (uint32_t g = 0; g < BandGroupCount(scene->bands.size()); ++g) SceneOfGroup(*scene, g);
    }
  }
  EXPECT_GT(refused, 5'000);
}

TEST(SceneValidate, RefusesSpectraThatMakeNoSense) {
  const auto refused = [](const Scene& scene, const char* why) {
    EXPECT_THAT(Validate(scene).message(), HasSubstr(why));
  };
  Scene scene = FourBands();
  scene.bands[1].low_nm = 480;
  refused(scene, "none within another");
  scene = FourBands();
  scene.bands[1].high_nm = scene.bands[1].low_nm;
  refused(scene, "none within another");
  scene = FourBands();
  scene.bands.pop_back();
  refused(scene, "a spectrum of 4 numbers for 3 bands");
  scene = FourBands();
  scene.materials[0].spectrum.reflectance[3] = 1;
  refused(scene, "material 0 'x low': reflectance outside [0, 1)");
  scene.materials[0].spectrum.reflectance[3] = .85;
  refused(scene, "below 1 together");
  scene = FourBands();
  scene.materials[2].spectrum.exitance[0] = -1;
  refused(scene, "exitance");
  scene = FourBands();
  scene.materials[1].reradiation.blue_to_red = 0.1;
  refused(scene, "take Fl or the spectra out");
  scene = FourBands();
  scene.materials[3].spectrum.reradiation.shares[4 * 2 + 1] = 0.1;
  refused(scene,
          "of band 3 0.1 comes out in band 2: give shares of what comes out in longer bands");
  scene = FourBands();
  scene.materials[3].spectrum.reradiation.shares[1] = 0.26;
  refused(scene, "of band 1 it reflects, passes on and reradiates 1.01");
  scene.materials[3].spectrum.reradiation.shares[1] = std::nan("");
  refused(scene, "of band 1");
  scene = FourBands();
  scene.materials[3].spectrum.reradiation.bands = 3;
  refused(scene, "between 3 bands, not 4");
  scene = FourBands();
  scene.textures.push_back({1, 1, Wrap::kRepeat, Wrap::kRepeat, {1, 1, 1}});
  scene.materials[0].reflectance_map.texture = 0;
  refused(scene, "both a map and a spectrum");
  scene = FourBands();
  scene.bands.assign(kMostBands + 1, {400, 401});
  refused(scene, "join some");
}

}  // namespace
}  // namespace isolux
