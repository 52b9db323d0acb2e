#include "client/web/page.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "client/web/bundle.h"
#include "common/util/build_info.h"

namespace isolux {
namespace {

using nlohmann::json;

const char* ToText(PageKind kind) {
  switch (kind) {
    case PageKind::kReport:
      return "report";
    case PageKind::kSweep:
      return "sweep";
  }
  return "";
}

// Text or the value of an attribute.
std::string EscapeMarkup(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

// JSON inside a script element, which ends at the first "</script" whatever stands around it and
// changes its meaning at "<!--". In JSON a '<' stands in strings only, so its escape is the same.
std::string EscapeData(const json& data) {
  const std::string text = data.dump(-1, ' ', false, json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      escaped += "\\u003c";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// Well-formed UTF-8.
std::string Repair(const std::string& text) {
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace))
      .get<std::string>();
}

}  // namespace

std::string MakePage(PageKind kind, const std::string& title, const json& data) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // Nothing is ever loaded, even if somebody edits the file; the icon keeps browsers from
      // asking for one.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "script-src 'unsafe-inline'; style-src 'unsafe-inline'\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>";
  page += EscapeMarkup(Repair(title));
  page += "</title>\n<style>\n";
  page += PageStyle();
  page += "</style>\n</head>\n<body data-page=\"";
  page += ToText(kind);
  page += "\" data-version=\"";
  page += EscapeMarkup(Version());
  page +=
      "\">\n<main>\n<noscript>This page draws its charts with the script inside it; allow scripts "
      "to see them.</noscript>\n</main>\n<script type=\"application/json\" id=\"data\">";
  page += EscapeData(data);
  page += "</script>\n<script>\n";
  page += PageScript();
  page += "</script>\n</body>\n</html>\n";
  return page;
}

std::string DataAddress(const std::string& media_type, const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string address = "data:" + media_type + ";base64,";
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t j = 0; j < 3; ++j) {
      group = group << 8 | (i + j < bytes.size() ? static_cast<uint8_t>(bytes[i + j]) : 0u);
    }
    for (size_t j = 0; j < 4; ++j) {
      address += i + j <= bytes.size() ? kDigits[group >> (18 - 6 * j) & 63] : '=';
    }
  }
  return address;
}

}  // namespace isolux
