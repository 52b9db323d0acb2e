#include "tests/hard_cases/hard_case.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>

namespace isolux::testing {

HardCase::HardCase(std::string number, std::string name, std::string property, double bound)
    : number_(std::move(number)),
      name_(std::move(name)),
      property_(std::move(property)),
      bound_(bound) {}

void HardCase::Measure(double violation, const std::string& where) {
  ++measured_;
  if (std::isnan(violation)) violation = std::numeric_limits<double>::infinity();
  if (violation <= worst_) return;
  worst_ = violation;
  worst_where_ = where;
}

HardCase::~HardCase() {
  std::printf("case %s, %s: %s; worst of %llu: %.3g%s%s, bound %.3g\n", number_.c_str(),
              name_.c_str(), property_.c_str(), measured_, worst_,
              worst_where_.empty() ? "" : " at ", worst_where_.c_str(), bound_);
  EXPECT_GT(measured_, 0U) << "case " << number_ << " measured nothing";
  EXPECT_LE(worst_, bound_) << "case " << number_ << ", " << name_ << " at " << worst_where_;
  const char* path = std::getenv("ISOLUX_HARD_CASES");
  if (path == nullptr) return;
  if (std::FILE* file = std::fopen(path, "a")) {
    std::fprintf(file, "| %s | %s | %s | %llu | %.2g | %.2g |\n", number_.c_str(), name_.c_str(),
                 property_.c_str(), measured_, worst_, bound_);
    std::fclose(file);
  }
}

}  // namespace isolux::testing
