// Where the coordinator is when nobody says otherwise.
#pragma once

namespace isolux {

inline constexpr const char* kDefaultServer = "127.0.0.1:7400";
inline constexpr const char* kServerVariable = "ISOLUX_SERVER";  // of the environment

}  // namespace isolux
