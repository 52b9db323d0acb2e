// Script and style of the pages, bundled from client/web/src when the program is built.
#pragma once

#include <string_view>

namespace isolux {

std::string_view PageScript();
std::string_view PageStyle();

}  // namespace isolux
