#include "common/scene/patch_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "common/util/random.h"

namespace isolux {
namespace {

using ::testing::HasSubstr;

PatchFile TwoFaces() {
  PatchFile file;
  file.comments = {{"version", "1"}, {"unit", "m"}, {"summary", "{\"rounds\": 3}"}};
  for (int i = 0; i < 5; ++i) {
    PatchVertex v;
    v.position = Vec3(i % 3, i / 3, 0.25 * i);
    v.radiosity = {1.0F + static_cast<float>(i), 0.5F, 0.25F};
    v.irradiance = {2.0F + static_cast<float>(i), 1.0F, 0.125F};
    file.vertices.push_back(v);
  }
  PatchFace face;
  face.vertices = {0, 1, 2};
  face.radiosity = {1, 2, 3};
  face.irradiance = {4, 5, 6};
  face.emission = {0.5F, 0.25F, 0};
  face.error = 0.01F;
  face.polygon = 7;
  face.surface = 12;
  face.side = 1;
  face.path = 0x123456789abcdefULL;
  file.faces.push_back(face);
  face.vertices = {1, 4, 3, 2};
  face.path = 1;
  face.side = 0;
  file.faces.push_back(face);
  return file;
}

void ExpectEqual(const PatchFile& a, const PatchFile& b) {
  EXPECT_EQ(a.comments, b.comments);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (size_t i = 0; i < a.vertices.size(); ++i) {
    EXPECT_EQ(a.vertices[i].position, b.vertices[i].position);
    EXPECT_EQ(a.vertices[i].radiosity, b.vertices[i].radiosity);
    EXPECT_EQ(a.vertices[i].irradiance, b.vertices[i].irradiance);
  }
  ASSERT_EQ(a.faces.size(), b.faces.size());
  for (size_t i = 0; i < a.faces.size(); ++i) {
    EXPECT_EQ(a.faces[i].vertices, b.faces[i].vertices);
    EXPECT_EQ(a.faces[i].radiosity, b.faces[i].radiosity);
    EXPECT_EQ(a.faces[i].irradiance, b.faces[i].irradiance);
    EXPECT_EQ(a.faces[i].emission, b.faces[i].emission);
    EXPECT_EQ(a.faces[i].error, b.faces[i].error);
    EXPECT_EQ(a.faces[i].polygon, b.faces[i].polygon);
    EXPECT_EQ(a.faces[i].surface, b.faces[i].surface);
    EXPECT_EQ(a.faces[i].side, b.faces[i].side);
    EXPECT_EQ(a.faces[i].path, b.faces[i].path);
  }
}

TEST(PatchFile, ComesBackAsItWas) {
  const PatchFile file = TwoFaces();
  const std::string bytes = Encode(file);
  const auto back = DecodePatchFile(bytes, "test.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  ExpectEqual(file, *back);
  EXPECT_EQ(Encode(*back), bytes);
  EXPECT_EQ(back->Comment("unit"), "m");
  EXPECT_EQ(back->Comment("nothing"), "");
}

// The same with two spectral bands.
PatchFile WithBands() {
  PatchFile file = TwoFaces();
  file.bands = {{400, 490.5}, {490.5, 580}};
  const auto fill = [](size_t items, BandValues* to) {
    for (size_t i = 0; i < 4 * items; ++i) to->values.push_back(static_cast<float>(i) + 0.25F);
  };
  fill(file.vertices.size(), &file.vertex_bands);
  fill(file.faces.size(), &file.face_bands);
  return file;
}

TEST(PatchFile, BandsComeBack) {
  const PatchFile file = WithBands();
  const std::string bytes = Encode(file);
  const auto back = DecodePatchFile(bytes, "bands.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  ExpectEqual(file, *back);
  EXPECT_EQ(back->bands, file.bands);
  EXPECT_EQ(back->vertex_bands.values, file.vertex_bands.values);
  EXPECT_EQ(back->face_bands.values, file.face_bands.values);
  EXPECT_EQ(Encode(*back), bytes);
  EXPECT_EQ(back->vertex_bands.Irradiance(1, 2)[1], 7.25F);
  EXPECT_EQ(back->vertex_bands.Radiosity(1, 2)[1], 5.25F);
  const std::string header = bytes.substr(0, bytes.find("end_header"));
  EXPECT_THAT(header, HasSubstr("comment isolux band 2 490.5 580\n"));
  EXPECT_THAT(header, HasSubstr("property float irradiance_b\nproperty float radiosity_band_1\n"));
  EXPECT_THAT(header, HasSubstr("property uint path_high\nproperty float radiosity_band_1\n"));
}

TEST(PatchFile, BandsMustBeToldOneByOne) {
  const std::string good = Encode(WithBands());
  for (const auto& [from, to] : {std::pair("band 2 490.5 580", "band 3 490.5 580"),
                                 std::pair("band 2 490.5 580", "band 2 490.5 480"),
                                 std::pair("band 2 490.5 580", "band 2 490.5"),
                                 std::pair("band 2 490.5 580", "other 490.5 580")}) {
    std::string bytes = good;
    bytes.replace(bytes.find(from), std::string(from).size(), to);
    EXPECT_FALSE(DecodePatchFile(bytes, "bands.ply").has_value()) << to;
  }
  PatchFile file = WithBands();
  file.face_bands.values[7] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(DecodePatchFile(Encode(file), "nan.ply").error().message(), HasSubstr("face 1"));
}

TEST(PatchFile, HeaderIsPlainPly) {
  const std::string bytes = Encode(TwoFaces());
  const std::string header = bytes.substr(0, bytes.find("end_header"));
  EXPECT_EQ(header.find("ply\nformat binary_little_endian 1.0\ncomment isolux version 1\n"), 0U);
  EXPECT_THAT(header, HasSubstr("element vertex 5\nproperty float x\n"));
  EXPECT_THAT(header, HasSubstr("property uchar red\n"));
  EXPECT_THAT(header, HasSubstr("element face 2\nproperty list uchar uint vertex_indices\n"));
  EXPECT_THAT(header, HasSubstr("property uint path_low\nproperty uint path_high\n"));
}

TEST(PatchFile, EmptyFileComesBack) {
  const auto back = DecodePatchFile(Encode(PatchFile{}), "empty.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_TRUE(back->faces.empty());
}

TEST(PatchFile, FarFromTheOriginPositionsAreDouble) {
  PatchFile file = TwoFaces();
  for (PatchVertex& v : file.vertices) v.position += Vec3(500'000.125, 4'000'000.0625, 0);
  const std::string bytes = Encode(file);
  EXPECT_THAT(bytes.substr(0, 400), HasSubstr("property double x\n"));
  const auto back = DecodePatchFile(bytes, "far.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  ExpectEqual(file, *back);
}

TEST(PatchFile, FacesMayHaveManyVertices) {
  PatchFile file = TwoFaces();
  file.faces[1].vertices.assign(300, 2);
  const auto back = DecodePatchFile(Encode(file), "many.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  ExpectEqual(file, *back);
}

TEST(PatchFile, CommentsStayOnTheirLine) {
  PatchFile file = TwoFaces();
  file.comments = {{"a key", "two\nlines"}};
  const auto back = DecodePatchFile(Encode(file), "lines.ply");
  ASSERT_TRUE(back.has_value()) << back.error().message();
  EXPECT_EQ(back->Comment("a_key"), "two lines");
}

TEST(PatchFile, ErrorsSayWhere) {
  EXPECT_THAT(DecodePatchFile("solid cube\n", "cube.stl").error().message(),
              HasSubstr("cube.stl:1: "));
  const std::string bytes = Encode(TwoFaces());
  EXPECT_THAT(DecodePatchFile(bytes.substr(0, bytes.size() - 1), "short.ply").error().message(),
              HasSubstr("short.ply: face 1 breaks off"));
  EXPECT_THAT(DecodePatchFile(bytes + "x", "long.ply").error().message(),
              HasSubstr("1 bytes too many"));
  PatchFile file = TwoFaces();
  file.faces[1].vertices[2] = 5;
  EXPECT_THAT(DecodePatchFile(Encode(file), "index.ply").error().message(), HasSubstr("face 1"));
  file = TwoFaces();
  file.vertices[3].irradiance[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(DecodePatchFile(Encode(file), "nan.ply").error().message(), HasSubstr("vertex 3"));
  EXPECT_THAT(ReadPatchFile("/nonexistent/a.ply").error().message(),
              HasSubstr("/nonexistent/a.ply"));
}

TEST(PatchFile, HugeCountsTakeNoMemory) {
  std::string bytes = Encode(TwoFaces());
  const size_t at = bytes.find("element vertex 5");
  bytes.replace(at, 16, "element vertex 2000000000");
  EXPECT_FALSE(DecodePatchFile(bytes, "huge.ply").has_value());
  bytes = Encode(TwoFaces());
  bytes.replace(bytes.find("element face 2"), 14, "element face 2000000000");
  EXPECT_FALSE(DecodePatchFile(bytes, "huge.ply").has_value());
}

// Damaged bytes give a Status or a file that is whole in itself; never a crash.
TEST(PatchFile, SurvivesDamage) {
  constexpr uint64_t kSeed = 20240611;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  const std::string without = Encode(TwoFaces()), with = Encode(WithBands());
  Random random(kSeed);
  int accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string bytes = trial % 2 == 0 ? without : with;
    const int changes = 1 + static_cast<int>(random.Bits() % 4);
    for (int k = 0; k < changes && !bytes.empty(); ++k) {
      const size_t at = random.Bits() % bytes.size();
      switch (random.Bits() % 4) {
        case 0:
          bytes[at] = static_cast<char>(random.Bits());
          break;
        case 1:
          bytes.erase(at, 1 + random.Bits() % 8);
          break;
        case 2:
          bytes.insert(at, 1 + random.Bits() % 8, static_cast<char>(random.Bits()));
          break;
        default:
          bytes.resize(at);
          break;
      }
    }
    const auto file = DecodePatchFile(bytes, "damaged.ply");
    if (!file.has_value()) {
      EXPECT_FALSE(file.error().message().empty());
      continue;
    }
    ++accepted;
    ASSERT_EQ(file->vertex_bands.values.size(), 2 * file->bands.size() * file->vertices.size());
    for (const PatchFace& face : file->faces) {
      for (const uint32_t v : face.vertices) ASSERT_LT(v, file->vertices.size());
    }
  }
  EXPECT_LT(accepted, 20'000);
}

TEST(PatchFile, WritesWholeOrNotAtAll) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "isolux_patch_file_test";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "a.ply").string();
  ASSERT_TRUE(WritePatchFile(TwoFaces(), path).ok());
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  const auto back = ReadPatchFile(path);
  ASSERT_TRUE(back.has_value()) << back.error().message();
  ExpectEqual(TwoFaces(), *back);
  const Status status = WritePatchFile(TwoFaces(), (folder / "absent" / "a.ply").string());
  EXPECT_THAT(status.message(), HasSubstr("absent"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isolux
