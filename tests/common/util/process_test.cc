#include "common/util/process.h"

#include <gtest/gtest.h>

#include <csignal>

#include "common/util/file.h"

namespace isolux {
namespace {

constexpr double kLong = 60;

Result<ChildProcess> Shell(const std::string& script, ChildProcess::Options options = {}) {
  return ChildProcess::Start({"sh", "-c", script}, options);
}

TEST(ProcessTest, ExitCodesAndSignalsAreTold) {
  auto child = Shell("exit 7");
  ASSERT_TRUE(child.has_value());
  EXPECT_TRUE(child->Wait(kLong));
  EXPECT_EQ(child->exit_code(), 7);
  auto sleeper = Shell("exec sleep 1000");
  ASSERT_TRUE(sleeper.has_value());
  EXPECT_TRUE(sleeper->Running());
  EXPECT_FALSE(sleeper->Wait(0.01));
  sleeper->Signal(SIGTERM);
  EXPECT_TRUE(sleeper->Wait(kLong));
  EXPECT_EQ(sleeper->exit_code(), 128 + SIGTERM);
}

TEST(ProcessTest, AProgramThatIsNotThere) {
  auto child = ChildProcess::Start({"/absent/program"}, {});
  ASSERT_FALSE(child.has_value());
  EXPECT_EQ(child.error().code(), StatusCode::kNotFound);
  EXPECT_NE(child.error().message().find("/absent/program"), std::string::npos);
}

TEST(ProcessTest, OutputIsReadByLines) {
  ChildProcess::Options options;
  options.pipe_output = true;
  auto child = Shell("echo one; echo two; exec sleep 1000", options);
  ASSERT_TRUE(child.has_value());
  EXPECT_EQ(*child->ReadLine(kLong), "one");
  EXPECT_EQ(*child->ReadLine(kLong), "two");
  EXPECT_EQ(child->ReadLine(0.01).error().code(), StatusCode::kDeadlineExceeded);
  child->Signal(SIGKILL);
  EXPECT_EQ(child->ReadLine(kLong).error().code(), StatusCode::kUnavailable);
}

TEST(ProcessTest, OutputGoesToFiles) {
  auto folder = TemporaryDirectory::Make("isolux-test-");
  ASSERT_TRUE(folder.has_value());
  ChildProcess::Options options;
  options.output_file = folder->path() + "/out";
  options.error_file = folder->path() + "/error";
  auto child = Shell("echo data; echo talk >&2", options);
  ASSERT_TRUE(child.has_value());
  EXPECT_TRUE(child->Wait(kLong));
  EXPECT_EQ(*ReadFile(options.output_file), "data\n");
  EXPECT_EQ(*ReadFile(options.error_file), "talk\n");
}

TEST(ProcessTest, AChildGoesWithItsObject) {
  pid_t id = 0;
  {
    auto child = Shell("exec sleep 1000");
    ASSERT_TRUE(child.has_value());
    id = child->id();
    EXPECT_EQ(::kill(id, 0), 0);
  }
  EXPECT_NE(::kill(id, 0), 0);
}

}  // namespace
}  // namespace isolux
