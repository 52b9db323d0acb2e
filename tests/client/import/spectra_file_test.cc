// Spectra of isolux.json.
#include "client/import/spectra_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "client/import/import.h"
#include "client/import/lights_file.h"
#include "common/util/random.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

constexpr char kGood[] = R"({"spectra": {
  "bands_nm": [[400, 450], [450, 490], [490, 580], [600, 700]],
  "materials": {"wall": {"reflectance": [0.1, 0.4, 0.5, 0.6], "transmittance": 0.05},
                "lamp": {"exitance_w_m2": [1, 2, 3, 4]}}}})";

constexpr char kGlowing[] = R"({"spectra": {
    "bands_nm": [[400, 450], [450, 490], [490, 580], [600, 700]],
    "materials": {
      "wall": {"reflectance": 0.2, "reradiation":
        [[0, 0.1, 0.2, 0.05], [0, 0, 0.3, 0], [0, 0, 0, 0.4], [0, 0, 0, 0]]},
      "plain": {"reradiation": [[0, 0.1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]}}}})";

constexpr char kObject[] = R"(mtllib room.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
usemtl wall
f 1 2 3
usemtl lamp
f 1 3 4
usemtl plain
f 1 4 2
usemtl pane
f 2 3 4
)";

constexpr char kMaterials[] = R"(newmtl wall
Kd 0.9 0.9 0.9
newmtl lamp
Kd 0.2 0.3 0.4
Ke 9 9 9
newmtl plain
Kd 0.5 0.6 0.7
newmtl pane
Kd 0 0 0
d 0.1
newmtl painted
Kd 0.5 0.5 0.5
map_Kd picture.png
)";

class Spectra : public ::testing::Test {
 protected:
  Result<Scene> Import(const std::string& json, const std::string& materials = kMaterials) {
    folder_.Write("isolux.json", json);
    folder_.Write("room.mtl", materials);
    return ImportScene(folder_.Write("room.obj", kObject), {});
  }
  std::string ErrorOf(const std::string& json, const std::string& materials = kMaterials) {
    const auto scene = Import(json, materials);
    EXPECT_FALSE(scene.has_value()) << json;
    if (scene.has_value()) return {};
    EXPECT_THAT(scene.error().message(), HasSubstr("isolux.json"));
    return scene.error().message();
  }
  const Material* Find(const Scene& scene, const std::string& name) {
    for (const Material& material : scene.materials) {
      if (material.name == name) return &material;
    }
    return nullptr;
  }

  testing::TempDir folder_;
};

TEST_F(Spectra, BecomeBandsAndChannels) {
  const auto scene = Import(kGood);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  ASSERT_EQ(scene->bands.size(), 4U);
  EXPECT_EQ(scene->bands[3], (Band{600, 700}));
  const Material* wall = Find(*scene, "wall");
  ASSERT_NE(wall, nullptr);
  EXPECT_EQ(wall->spectrum.reflectance, (std::vector<double>{.1, .4, .5, .6}));
  EXPECT_EQ(wall->spectrum.transmittance, std::vector<double>(4, .05));
  EXPECT_NEAR(wall->reflectance.z, (50 * .1 + 40 * .4) / 90, 1e-15);  // by width
  EXPECT_EQ(wall->reflectance.y, .5);
  EXPECT_EQ(wall->reflectance.x, .6);
  const Material* lamp = Find(*scene, "lamp");
  ASSERT_NE(lamp, nullptr);
  EXPECT_EQ(lamp->exitance, Rgb(4, 3, 3));
  EXPECT_EQ(lamp->reflectance, Rgb(.2, .3, .4));
  EXPECT_FALSE(Find(*scene, "plain")->spectrum.exists());
}

TEST_F(Spectra, FluorescenceBecomesThatOfChannels) {
  const auto scene = Import(kGlowing);
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  const Material* wall = Find(*scene, "wall");
  EXPECT_EQ(wall->spectrum.reradiation.Share(0, 2), 0.2);
  EXPECT_NEAR(wall->spectrum.reradiation.LargestTaken(), 0.4, 1e-15);
  EXPECT_NEAR(wall->reradiation.blue_to_green, (50 * .2 + 40 * .3) / 90, 1e-15);
  EXPECT_NEAR(wall->reradiation.blue_to_red, 50 * .05 / 90, 1e-15);
  EXPECT_EQ(wall->reradiation.green_to_red, 0.4);
  EXPECT_NEAR(wall->reflectance.z, .2 + 50 * .1 / 90, 1e-15);  // blue that stays blue
  EXPECT_EQ(wall->reflectance.y, .2);
  // A reflectance that is not given is what the file says, not what the channel hands on.
  const Material* plain = Find(*scene, "plain");
  EXPECT_EQ(plain->spectrum.reflectance, (std::vector<double>{.7, .7, .6, .5}));
  EXPECT_NEAR(plain->reflectance.z, .7 + 50 * .1 / 90, 1e-15);
}

TEST_F(Spectra, LightOfAChannelWithoutBandsDoesNotCount) {
  const auto scene = Import(R"({"spectra": {"bands_nm": [[500, 560]]},
    "lights": [{"type": "point", "position": [1, 1, 1], "intensity": [1, 2, 3]}]})");
  ASSERT_TRUE(scene.has_value()) << scene.error().message();
  EXPECT_EQ(Find(*scene, "lamp")->exitance, Rgb(0, 9 * std::numbers::pi, 0));
  ASSERT_EQ(scene->lights.size(), 1U);
  EXPECT_EQ(scene->lights[0].intensity, Rgb(0, 2, 0));
}

TEST_F(Spectra, ErrorsNameThePlaceAndTheRemedy) {
  const auto spectra = [](const std::string& rest) { return R"({"spectra": {)" + rest + "}}"; };
  const std::string bands = R"("bands_nm": [[400, 500], [500, 600]])";
  const auto materials = [&](const std::string& rest) {
    return spectra(bands + R"(, "materials": {)" + rest + "}");
  };
  for (const char* wrong :
       {R"("materials": {})", R"("bands_nm": [])", R"("bands_nm": 3)",
        R"("bands_nm": [[500, 400]])", R"("bands_nm": [[400, 500], [490, 600]])",
        R"("bands_nm": [[400]])", R"("bands_nm": [["a", 500]])"}) {
    EXPECT_THAT(ErrorOf(spectra(wrong)), HasSubstr("from short to long")) << wrong;
  }
  EXPECT_THAT(ErrorOf(spectra(bands + R"(, "colour": 1)")), HasSubstr("no key 'colour'"));
  EXPECT_THAT(ErrorOf(materials(R"("wall": {"reflectance": [0.5]})")),
              HasSubstr("materials: wall: \"reflectance\" must be a number from 0 to 0.98, or 2"));
  EXPECT_THAT(ErrorOf(materials(R"("wall": {"reflectance": [0.5, 1]})")), HasSubstr("0.98"));
  EXPECT_THAT(ErrorOf(materials(R"("wall": {"exitance_w_m2": -1})")), HasSubstr("exitance_w_m2"));
  EXPECT_THAT(ErrorOf(materials(R"("wall": {})")), HasSubstr("no spectrum"));
  EXPECT_THAT(ErrorOf(materials(R"("wal": {"reflectance": 0.5})")),
              HasSubstr("the scene has no material 'wal'"));
  EXPECT_THAT(ErrorOf(materials(R"("pane": {"reflectance": 0.5})")), HasSubstr("clear glass"));
  EXPECT_THAT(ErrorOf(materials(R"("painted": {"reflectance": 0.5})")),
              HasSubstr("take the map or the spectrum out"));
  std::string glowing = kMaterials;
  const std::string plain = "Kd 0.5 0.6 0.7\n";
  glowing.insert(glowing.find(plain) + plain.size(), "Fl 0.1 0 0\n");
  const auto fluorescent = Import(spectra(bands), glowing);
  ASSERT_FALSE(fluorescent.has_value());
  EXPECT_THAT(fluorescent.error().message(), HasSubstr("take Fl or the spectra out"));
  const std::string wall = R"("wall": {"reflectance": 0.5, "reradiation": )";
  EXPECT_THAT(ErrorOf(materials(wall + "[[0, 0.2]]}")), HasSubstr("must be 2 rows"));
  EXPECT_THAT(ErrorOf(materials(wall + "0.2}")), HasSubstr("must be 2 rows"));
  EXPECT_THAT(ErrorOf(materials(wall + "[[0, 0.2], [0]]}")), HasSubstr("row 2 must be 2 numbers"));
  EXPECT_THAT(ErrorOf(materials(wall + "[[0, -0.2], [0, 0]]}")), HasSubstr("from 0 to 0.98"));
  EXPECT_THAT(ErrorOf(materials(wall + "[[0, 0.2], [0.1, 0]]}")),
              HasSubstr("materials: wall: \"reradiation\": row 2: light comes out in longer bands "
                        "alone; write 0 in column 1"));
  EXPECT_THAT(ErrorOf(materials(wall + "[[0.1, 0.2], [0, 0]]}")), HasSubstr("column 1"));
  EXPECT_THAT(ErrorOf(materials(wall + "[[0, 0.5], [0, 0]]}")),
              HasSubstr("wall: of band 1 (400 to 500 nm) it reflects, passes on and reradiates 1; "
                        "lower these to 0.98 together"));
  // Of the reflectance of the file, too.
  EXPECT_THAT(ErrorOf(materials(R"("wall": {"reradiation": [[0, 0.2], [0, 0]]})")),
              HasSubstr("reradiates 1.1"));
}

TEST_F(Spectra, DamagedTextGivesAnErrorOrSpectra) {
  constexpr uint64_t kSeed = 20261130;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  int refused = 0;
  for (int trial = 0; trial < 4'000; ++trial) {
    std::string text = trial % 2 == 0 ? kGood : kGlowing;
    for (uint64_t edits = 1 + random.Bits() % 3; edits > 0; --edits) {
      text[random.Bits() % text.size()] = "0123456789[]{},:.-\"e"[random.Bits() % 21];
    }
    SceneFile file;
    const Status status = ParseLightsFile(text, "isolux.json", &file);
    refused += status.ok() ? 0 : 1;
    for (const FileSpectrum& named : file.spectra) {
      if (!status.ok()) break;
      EXPECT_TRUE(named.spectrum.exists());
    }
  }
  EXPECT_GT(refused, 2'000);
}

}  // namespace
}  // namespace isolux
