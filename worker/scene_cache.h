// Scenes by hash, so that a second job, or a restart, costs no transfer. One thread.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "common/scene/scene.h"

namespace isolux {

class SceneCache {
 public:
  // Keeps the most recently used scenes whose encoded sizes add up to at most `limit_bytes`, and
  // the last one in any case.
  explicit SceneCache(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  // Null when it is not here.
  std::shared_ptr<const Scene> Find(const std::string& hash);
  void Insert(const std::string& hash, std::shared_ptr<const Scene> scene, uint64_t bytes);

  size_t size() const { return entries_.size(); }
  uint64_t bytes() const { return bytes_; }

 private:
  struct Entry {
    std::string hash;
    std::shared_ptr<const Scene> scene;
    uint64_t bytes = 0;
  };

  uint64_t limit_bytes_;
  uint64_t bytes_ = 0;
  std::list<Entry> entries_;  // most recently used first
};

}  // namespace isolux
