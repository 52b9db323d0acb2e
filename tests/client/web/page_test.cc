#include "client/web/page.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "common/util/build_info.h"

namespace isolux {
namespace {

using nlohmann::json;

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// What the page's script reads.
json DataOf(const std::string& page) {
  const std::string start = "id=\"data\">";
  const size_t begin = page.find(start) + start.size();
  return json::parse(page.substr(begin, page.find("</script>", begin) - begin), nullptr, false);
}

TEST(PageTest, IsOneFileThatNamesItsKindAndLanguage) {
  const std::string page =
      MakePage(PageKind::kSweep, "What accuracy costs", {{"runs", json::array()}});
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>\n<html lang=\"en\">"));
  EXPECT_NE(page.find("<title>What accuracy costs</title>"), std::string::npos);
  EXPECT_NE(page.find("data-page=\"sweep\""), std::string::npos);
  EXPECT_NE(page.find("data-version=\"" + Version() + "\""), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(Count(page, "<script"), 2u);
  EXPECT_EQ(Count(page, "</script>"), 2u);
  EXPECT_EQ(Count(page, " src="), 0u);
  EXPECT_NE(MakePage(PageKind::kReport, "", {}).find("data-page=\"report\""), std::string::npos);
}

TEST(PageTest, DataCannotLeaveItsElement) {
  const std::string evil = "</script><script>alert(1)</script><!-- <b>";
  const json data = {{evil, evil}, {"list", {1, "a < b & c > d", nullptr}}};
  const std::string page = MakePage(PageKind::kSweep, "t", data);
  EXPECT_EQ(Count(page, "<script"), 2u);
  EXPECT_EQ(Count(page, "</script"), 2u);
  EXPECT_EQ(page.find("alert(1)<"), std::string::npos);
  EXPECT_EQ(DataOf(page), data);
}

TEST(PageTest, ATitleIsText) {
  const std::string page = MakePage(PageKind::kSweep, "a<b>&\"c\"</title>.obj", {});
  EXPECT_NE(page.find("<title>a&lt;b&gt;&amp;&quot;c&quot;&lt;/title&gt;.obj</title>"),
            std::string::npos);
}

TEST(PageTest, WhatIsNoTextOrNumberDoesNoHarm) {
  const std::string page =
      MakePage(PageKind::kSweep, "\xff.obj",
               {{"scene", "\xc3\x28"}, {"x", std::numeric_limits<double>::quiet_NaN()}});
  EXPECT_NE(page.find("<title>\xEF\xBF\xBD.obj</title>"), std::string::npos);
  EXPECT_EQ(DataOf(page)["x"], json());
  EXPECT_EQ(DataOf(page)["scene"], "\xEF\xBF\xBD(");
}

TEST(PageTest, DataAddress) {
  EXPECT_EQ(DataAddress("image/png", ""), "data:image/png;base64,");
  EXPECT_EQ(DataAddress("a/b", "f"), "data:a/b;base64,Zg==");
  EXPECT_EQ(DataAddress("a/b", "fo"), "data:a/b;base64,Zm8=");
  EXPECT_EQ(DataAddress("a/b", "foo"), "data:a/b;base64,Zm9v");
  EXPECT_EQ(DataAddress("a/b", std::string("\x00\xff\xfe\x80", 4)), "data:a/b;base64,AP/+gA==");
}

}  // namespace
}  // namespace isolux
