// Pages for people, made from data: one HTML file each, with its script, style and data inside,
// that loads nothing from anywhere. docs/report.md describes the data that each kind takes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace isolux {

enum class PageKind {
  kReport,  // what one solve took and reached
  kSweep,   // what accuracy costs, over several solves
};

// The whole file, in UTF-8. Whatever `title` and `data` hold is shown as text, never read as markup
// or script; bytes that are no UTF-8 show as replacement characters, values that are no numbers as
// missing.
std::string MakePage(PageKind kind, const std::string& title, const nlohmann::json& data);

// `bytes` as a "data:" address of the media type, for pictures in a page.
std::string DataAddress(const std::string& media_type, const std::string& bytes);

}  // namespace isolux
