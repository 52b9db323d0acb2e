// Which build this is. Coordinator and workers must compute the same bits, so they compare these.
#pragma once

#include <string>

#include "common/util/status.h"

namespace isolux {

const std::string& Version();  // "0.1.0"
// Version, build type, compiler and a hash of the sources that decide what is computed.
const std::string& BuildId();
const std::string& InstructionSet();  // what the code was compiled for: "x86-64-v3"

// Whether this processor has that instruction set; for the first lines of main.
Status CheckProcessor();

}  // namespace isolux
