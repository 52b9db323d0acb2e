// make_page report|sweep DATA.json PAGE.html: a page from any data, for tests in a browser. The
// title is data["title"].
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/web/page.h"
#include "common/util/file.h"

namespace isolux {
namespace {

Status Make(const std::string& kind, const std::string& input, const std::string& output) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(input));
  const auto data = nlohmann::json::parse(text, nullptr, false);
  if (!data.is_object()) return MakeStatus(StatusCode::kInvalidArgument, "{}: no object", input);
  return WriteFileDurably(output, MakePage(kind == "sweep" ? PageKind::kSweep : PageKind::kReport,
                                           data.value("title", ""), data));
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: make_page report|sweep DATA.json PAGE.html\n");
    return 2;
  }
  const isolux::Status status = isolux::Make(argv[1], argv[2], argv[3]);
  if (!status.ok()) std::fprintf(stderr, "make_page: %s\n", status.message().c_str());
  return status.ok() ? 0 : 1;
}
