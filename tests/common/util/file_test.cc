#include "common/util/file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/scene/scene.h"
#include "common/util/digest.h"

namespace isolux {
namespace {

TEST(FileTest, WhatIsWrittenIsRead) {
  auto folder = TemporaryDirectory::Make("isolux-test-");
  ASSERT_TRUE(folder.has_value());
  const std::string path = folder->path() + "/a/b";
  EXPECT_EQ(ReadFile(path).error().code(), StatusCode::kNotFound);
  EXPECT_FALSE(WriteFileDurably(path, "x").ok());
  ASSERT_TRUE(MakeDirectories(folder->path() + "/a").ok());
  const std::string bytes("with\0zero", 9);
  ASSERT_TRUE(WriteFileDurably(path, bytes).ok());
  EXPECT_EQ(*ReadFile(path), bytes);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  EXPECT_EQ(ReadFile(path, 8).error().code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(ReadFile(folder->path()).error().code(), StatusCode::kInvalidArgument);
}

TEST(FileTest, ATemporaryDirectoryGoesWithAllThatIsInIt) {
  std::string path;
  {
    auto folder = TemporaryDirectory::Make("isolux-test-");
    ASSERT_TRUE(folder.has_value());
    path = folder->path();
    ASSERT_TRUE(MakeDirectories(path + "/deep/er").ok());
    TemporaryDirectory moved = std::move(*folder);
    EXPECT_EQ(moved.path(), path);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(FileTest, ALockIsHeldByOne) {
  auto folder = TemporaryDirectory::Make("isolux-test-");
  ASSERT_TRUE(folder.has_value());
  const std::string path = folder->path() + "/lock";
  {
    auto first = FileLock::Take(path);
    ASSERT_TRUE(first.has_value());
    auto second = FileLock::Take(path);
    ASSERT_FALSE(second.has_value());
    EXPECT_EQ(second.error().code(), StatusCode::kFailedPrecondition);
  }
  EXPECT_TRUE(FileLock::Take(path).has_value());
}

TEST(DigestTest, PiecesGiveTheHashOfTheWhole) {
  const std::string bytes(100'000, 'q');
  Digest digest;
  digest.Add(std::string_view(bytes).substr(0, 77));
  digest.Add(std::string_view(bytes).substr(77));
  EXPECT_EQ(digest.Finish(), HashOf(bytes));
  EXPECT_NE(Checksum("a"), Checksum("b"));
}

}  // namespace
}  // namespace isolux
