// One hard case: a situation that breaks solvers, the property that must hold in it, and the worst
// violation found. `docs/hard-cases.md` is made from these by tests/bench/hard_cases.sh.
#pragma once

#include <string>

namespace isolux::testing {

// Give it every violation found; when it ends it prints the worst one, fails the test where that
// is above the bound (or not a number, or nothing was ever measured), and adds a line to the file
// that $ISOLUX_HARD_CASES names, if any.
class HardCase {
 public:
  // number: sorts the table ("14", "46"). property: what must hold, in one line. bound: what a
  // violation may be at most, in the property's own unit.
  HardCase(std::string number, std::string name, std::string property, double bound);
  ~HardCase();
  HardCase(const HardCase&) = delete;
  HardCase& operator=(const HardCase&) = delete;

  // where: what tells this measurement from the others, for instance a seed.
  void Measure(double violation, const std::string& where = "");

 private:
  std::string number_, name_, property_, worst_where_;
  double bound_;
  double worst_ = -1;
  unsigned long long measured_ = 0;
};

}  // namespace isolux::testing
