// Script and style of the pages, bundled from client/web/src when the program is built.
#pragma once

namespace isolux {

extern const char kPageScript[];
extern const char kPageStyle[];

}  // namespace isolux
