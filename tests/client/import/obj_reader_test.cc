#include "client/import/obj_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/import/mtl_reader.h"
#include "tests/support/temp_dir.h"

namespace isolux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TempDir;

const char kSquare[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

SceneFile Read(const std::string& text) {
  Result<SceneFile> file = ParseObj(text, "test.obj");
  EXPECT_TRUE(file.has_value()) << file.error().message();
  return file.has_value() ? *file : SceneFile();
}

std::string ErrorOf(const std::string& text) {
  const Result<SceneFile> file = ParseObj(text, "test.obj");
  EXPECT_FALSE(file.has_value());
  return file.has_value() ? "" : file.error().message();
}

TEST(ObjReader, ReadsFacesOfAnyCornerCount) {
  const SceneFile file =
      Read(std::string(kSquare) + "v 0.5 2 0\nf 1 2 3\nf 1 2 3 4\nf 1 2 3 5 4\n");
  EXPECT_EQ(file.points.size(), 5U);
  EXPECT_EQ(file.points[4], Vec3(0.5, 2, 0));
  ASSERT_EQ(file.faces.size(), 3U);
  EXPECT_EQ(file.faces[2].count, 5U);
  EXPECT_EQ(file.faces[2].place, 8U);
  EXPECT_EQ(file.faces[2].material, kNoMaterial);
  EXPECT_THAT(file.corners, ElementsAre(0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 4, 3));
}

TEST(ObjReader, CountsNegativeIndicesFromTheFace) {
  const SceneFile file =
      Read("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf -3/1 -2/1 -1/1\n");
  EXPECT_THAT(file.corners, ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(ObjReader, TakesTextureAndNormalIndices) {
  EXPECT_THAT(Read(std::string(kSquare) + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n").corners,
              ElementsAre(0, 1, 2));
  EXPECT_THAT(Read(std::string(kSquare) + "f 1//1 2//1 3//1\n").corners, ElementsAre(0, 1, 2));
  EXPECT_THAT(Read(std::string(kSquare) + "f 1/1 2/1 3/1\n").corners, ElementsAre(0, 1, 2));
  EXPECT_THAT(Read(std::string(kSquare) + "f 1/ 2/ 3/\n").corners, ElementsAre(0, 1, 2));
}

TEST(ObjReader, IgnoresCommentsBehindValuesAndCarriageReturns) {
  const SceneFile file = Read(
      "# a head\r\nv 0 0 0 # origin\r\nv 1 0 0\t# x\r\nv 1 1 0\r\n\r\n# f 1 1 1\r\nf 1 2 3 # "
      "floor\r\n");
  EXPECT_EQ(file.faces.size(), 1U);
  EXPECT_EQ(file.faces[0].place, 7U);
  EXPECT_EQ(file.faces[0].count, 3U);
}

TEST(ObjReader, ReadsOldMacintoshLinesBomAndNoFinalNewline) {
  EXPECT_EQ(Read("v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3").faces[0].place, 4U);
  EXPECT_EQ(Read("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3").faces.size(), 1U);
}

TEST(ObjReader, JoinsContinuedLines) {
  const SceneFile file = Read(std::string(kSquare) + "f 1 2 \\\n  3 \\\r\n 4\nf 1 2 3\n");
  ASSERT_EQ(file.faces.size(), 2U);
  EXPECT_EQ(file.faces[0].count, 4U);
  EXPECT_EQ(file.faces[0].place, 7U);
  EXPECT_EQ(file.faces[1].place, 8U);
}

TEST(ObjReader, KeepsTheLastBitOfCoordinates) {
  const SceneFile file =
      Read("v 0.1 +2.5e-3 123456789.123456789\nv 1 0 0\nv 1e-400 1 0 1 0.5\nf 1 2 3\n");
  EXPECT_EQ(file.points[0], Vec3(0.1, 2.5e-3, 123456789.123456789));
  EXPECT_EQ(file.points[2], Vec3(0, 1, 0));
}

TEST(ObjReader, GroupsAndObjectsAndSmoothingDoNotMatter) {
  const SceneFile file = Read(std::string("o room\ng walls floor\ns 1\n") + kSquare +
                              "f 1 2 3\ng\ns off\nl 1 2\np 1\nf 2 3 4\ng other\nf 1 3 4\n");
  EXPECT_EQ(file.faces.size(), 3U);
}

TEST(ObjReader, NamesFileAndLineOfBadNumbers) {
  EXPECT_THAT(ErrorOf("v 0 0 0\nv nan 0 0\n"),
              HasSubstr("test.obj:2: a vertex needs three finite"));
  EXPECT_THAT(ErrorOf("v 0 inf 0\n"), HasSubstr("test.obj:1"));
  EXPECT_THAT(ErrorOf("v 0 0 1e999\n"), HasSubstr("1e999"));
  EXPECT_THAT(ErrorOf("\n\nv 0 0\n"), HasSubstr("test.obj:3"));
  EXPECT_THAT(ErrorOf("v 0 0 zero\n"), HasSubstr("'zero'"));
  EXPECT_THAT(ErrorOf("v 1,5 0 0\n"), HasSubstr("'1,5'"));
}

TEST(ObjReader, NamesFileAndLineOfBadFaces) {
  const std::string square = kSquare;
  EXPECT_THAT(ErrorOf(square + "f 1 2 5\n"), HasSubstr("test.obj:5: corner '5' names a vertex"));
  EXPECT_THAT(ErrorOf(square + "f 0 1 2\n"), HasSubstr("'0'"));
  EXPECT_THAT(ErrorOf(square + "f -5 -1 -2\n"), HasSubstr("'-5'"));
  EXPECT_THAT(ErrorOf("f 1 2 3\n" + square), HasSubstr("test.obj:1"));
  EXPECT_THAT(ErrorOf(square + "f 1 2\n"), HasSubstr("at least 3 corners, this one has 2"));
  EXPECT_THAT(ErrorOf(square + "f 1 2 x\n"), HasSubstr("'x' is not a corner"));
  EXPECT_THAT(ErrorOf(square + "f 1 2 3.5\n"), HasSubstr("'3.5'"));
  EXPECT_THAT(ErrorOf(square + "f 1 2 4294967299\n"), HasSubstr("4294967299"));
  std::string many = square + "f";
  for (int i = 0; i < 3000; ++i) many += " 1";
  EXPECT_THAT(ErrorOf(many), HasSubstr("3000 corners"));
}

TEST(ObjReader, RefusesWhatIsNoScene) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("no faces"));
  EXPECT_THAT(ErrorOf("Dear Sir or Madam,\n"), HasSubstr("no faces"));
  EXPECT_THAT(ErrorOf(std::string("\x7f"
                                  "ELF\n\0\0\0",
                                  8)),
              HasSubstr("not a text file"));
  EXPECT_THAT(ReadObj("/nonexistent/room.obj").error().message(), HasSubstr("No such file"));
  const TempDir dir;
  EXPECT_THAT(ReadObj(dir.path()).error().message(), HasSubstr("not a file"));
}

TEST(ObjReader, KeepsLimits) {
  SceneLimits limits;
  limits.vertices = 3;
  const std::string text = std::string(kSquare) + "f 1 2 3\nf 1 2 4\n";
  EXPECT_EQ(ParseObj(text, "a.obj", limits).error().code(), StatusCode::kResourceExhausted);
  limits = {};
  limits.polygons = 1;
  EXPECT_EQ(ParseObj(text, "a.obj", limits).error().code(), StatusCode::kResourceExhausted);
}

TEST(ObjReader, ReadsSeveralLibraries) {
  const TempDir dir;
  dir.Write("a.mtl", "newmtl one\nKd 0.1 0.2 0.3\n");
  dir.Write("b.mtl", "newmtl two\nKd 0.4\nnewmtl one\nKd 1 1 1\n");
  dir.Write("c d.mtl", "newmtl three\nKd 0 0 0\n");
  const std::string path = dir.Write(
      "room.obj", std::string("mtllib a.mtl b.mtl\nmtllib c d.mtl\n") + kSquare +
                      "usemtl three\nf 1 2 3\nusemtl one # red\nf 2 3 4\nusemtl two\nf 1 3 4\n");
  const Result<SceneFile> file = ReadObj(path);
  ASSERT_TRUE(file.has_value()) << file.error().message();
  EXPECT_EQ(file->materials[file->faces[0].material].name, "three");
  EXPECT_EQ(file->materials[file->faces[1].material].diffuse, Rgb(0.1, 0.2, 0.3));
  EXPECT_EQ(file->materials[file->faces[2].material].diffuse, Rgb(0.4));
  EXPECT_THAT(file->repeated_materials, ElementsAre(HasSubstr("b.mtl:3")));
}

TEST(ObjReader, FindsFilesInAnyCase) {
  const TempDir dir;
  dir.Write("LIB/ROOM.MTL", "newmtl Grey\r\nKd 0.5 0.5 0.5\r\n");
  const std::string path = dir.Write(
      "ROOM.OBJ", std::string("mtllib LIB\\room.mtl\r\nusemtl Grey\r\n") + kSquare + "f 1 2 3\r\n");
  const Result<SceneFile> file = ReadObj(path);
  ASSERT_TRUE(file.has_value()) << file.error().message();
  EXPECT_EQ(file->materials[0].diffuse, Rgb(0.5));
}

TEST(ObjReader, MaterialsMayFollowTheFaces) {
  const TempDir dir;
  dir.Write("late.mtl", "newmtl a\nKd 0.5 0.5 0.5\n");
  const std::string path =
      dir.Write("room.obj", std::string(kSquare) + "usemtl a\nf 1 2 3\nmtllib late.mtl\n");
  ASSERT_TRUE(ReadObj(path).has_value());
}

TEST(ObjReader, MissingMaterialsNameTheRemedy) {
  const TempDir dir;
  const std::string body = std::string(kSquare) + "usemtl red\nf 1 2 3\n";
  const std::string absent = dir.Write("absent.obj", "mtllib gone.mtl\n" + body);
  EXPECT_THAT(ReadObj(absent).error().message(),
              HasSubstr("absent.obj:6: material 'red' is missing, as is the library 'gone.mtl'"));
  EXPECT_THAT(ReadObj(absent).error().message(), HasSubstr("beside the scene"));
  dir.Write("other.mtl", "newmtl blue\n");
  const std::string unknown = dir.Write("unknown.obj", "mtllib other.mtl\n" + body);
  EXPECT_THAT(ReadObj(unknown).error().message(),
              HasSubstr("material 'red' is in no material library"));
  // A name that no face uses and a library that no face needs do not matter.
  const std::string unused =
      dir.Write("unused.obj", std::string("mtllib other.mtl gone.mtl\nusemtl red\nusemtl blue\n") +
                                  kSquare + "f 1 2 3\n");
  const Result<SceneFile> file = ReadObj(unused);
  ASSERT_TRUE(file.has_value()) << file.error().message();
  EXPECT_THAT(file->missing_libraries, ElementsAre(HasSubstr("unused.obj:1")));
}

TEST(MtlReader, ReadsWhatCounts) {
  const auto materials = ParseMtl(
      "# library\n"
      "newmtl plain  \nKa 1 1 1\nKd 0.25 0.5 0.75 # warm\nillum 1\n\n"
      "newmtl lamp\nKe 3\nmap_Ke glow.png\n"
      "newmtl map # textured\nmap_Kd -s 2 2 1 my wood.jpg\nmap_d leaf.png\n"
      "newmtl chrome\nKd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n"
      "newmtl plastic\nKd 0.3 0.3 0.3\nKs 0.04 0.04 0.04\nillum 2\n"
      "newmtl pane\nKd 0 0 0\nd 0\nillum 9\n"
      "newmtl filter\nTf 0.9 0.9 0.8\n"
      "newmtl opaque\nTf 1 1 1\nd 1\n",
      "lib/x.mtl");
  ASSERT_TRUE(materials.has_value()) << materials.error().message();
  ASSERT_EQ(materials->size(), 8U);
  const auto& m = *materials;
  EXPECT_EQ(m[0].name, "plain");
  EXPECT_EQ(m[0].where, "lib/x.mtl:2");
  EXPECT_EQ(m[0].diffuse_map.folder, "lib");
  EXPECT_EQ(m[0].diffuse, Rgb(0.25, 0.5, 0.75));
  EXPECT_EQ(m[1].radiance, Rgb(3.0));
  EXPECT_EQ(m[1].emission_map.name, "glow.png");
  EXPECT_EQ(m[2].name, "map");
  EXPECT_EQ(m[2].diffuse, Rgb(1.0));
  EXPECT_EQ(m[2].diffuse_map.name, "my wood.jpg");
  EXPECT_TRUE(m[2].opacity_map);
  EXPECT_TRUE(m[3].mirror && !m[3].glossy && !m[3].glass);
  EXPECT_EQ(m[3].specular, Rgb(0.9));
  EXPECT_TRUE(!m[4].mirror && m[4].glossy && !m[4].glass);
  EXPECT_TRUE(m[5].glass && m[6].glass && !m[7].glass);
}

TEST(MtlReader, NamesFileAndLineOfBadValues) {
  const auto error_of = [](const char* text) { return ParseMtl(text, "x.mtl").error().message(); };
  EXPECT_THAT(error_of("newmtl a\nKd 0.5 red 0\n"), HasSubstr("x.mtl:2: Kd 'red' is not a number"));
  EXPECT_THAT(error_of("newmtl a\nKd 0.5 0.5\n"), HasSubstr("one or three numbers"));
  EXPECT_THAT(error_of("newmtl a\nKe -1 0 0\n"), HasSubstr("'-1'"));
  EXPECT_THAT(error_of("newmtl a\n\nKe nan 0 0\n"), HasSubstr("x.mtl:3"));
  EXPECT_THAT(error_of("newmtl a\nKd spectral red.rfl\n"), HasSubstr("one or three"));
  EXPECT_THAT(error_of("Kd 1 1 1\nnewmtl a\n"), HasSubstr("before the first newmtl"));
  EXPECT_THAT(error_of("newmtl\nKd 1 1 1\n"), HasSubstr("newmtl without a name"));
}

}  // namespace
}  // namespace isolux
