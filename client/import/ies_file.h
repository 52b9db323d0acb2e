// Photometric files of luminaires: IES LM-63 of 1986 to 2002 and 2019, type C.
#pragma once

#include <string>

#include "common/scene/photometry.h"
#include "common/util/status.h"

namespace isolux {

// Intensities times the file's multiplier and ballast factors. Errors name file and line.
Result<Photometry> ReadIes(const std::string& path);
// The same from bytes; `name` stands in messages and in the result.
Result<Photometry> ParseIes(const std::string& bytes, const std::string& name);

}  // namespace isolux
