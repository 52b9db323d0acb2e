#include "common/util/build_info.h"

#include "isolux_build_id.h"

namespace isolux {

const std::string& Version() {
  static const std::string version = ISOLUX_VERSION;
  return version;
}

const std::string& BuildId() {
  static const std::string id = std::string(ISOLUX_VERSION) + "-" + ISOLUX_BUILD_TYPE +
                                "-gcc" __VERSION__ "-" + ISOLUX_SOURCE_HASH;
  return id;
}

const std::string& InstructionSet() {
#if defined(__AVX2__) && defined(__FMA__) && defined(__BMI2__)
  static const std::string name = "x86-64-v3";
#else
  static const std::string name = "x86-64";
#endif
  return name;
}

Status CheckProcessor() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2")) {
    return {};
  }
  return MakeStatus(StatusCode::kFailedPrecondition,
                    "this processor lacks AVX2, FMA or BMI2, which {} needs: run it on one of "
                    "2013 (Intel) or 2015 (AMD) or later",
                    InstructionSet());
}

}  // namespace isolux
