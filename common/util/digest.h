// Checks of bytes that travel or lie on disk: against damage, not against malice.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace isolux {

// XXH3-128 of bytes that come piece by piece, as 32 hexadecimal digits; the same as HashOf of the
// whole (common/scene/scene.h).
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  void Add(std::string_view bytes);
  std::string Finish() const;

 private:
  void* state_;
};

uint64_t Checksum(std::string_view bytes);  // XXH3-64

}  // namespace isolux
