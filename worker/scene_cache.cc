#include "worker/scene_cache.h"

#include <utility>

namespace isolux {

std::shared_ptr<const Scene> SceneCache::Find(const std::string& hash) {
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->hash != hash) continue;
    entries_.splice(entries_.begin(), entries_, entry);
    return entries_.front().scene;
  }
  return nullptr;
}

void SceneCache::Insert(const std::string& hash, std::shared_ptr<const Scene> scene,
                        uint64_t bytes) {
  if (Find(hash) != nullptr) return;
  entries_.push_front({hash, std::move(scene), bytes});
  bytes_ += bytes;
  while (bytes_ > limit_bytes_ && entries_.size() > 1) {
    bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
}

}  // namespace isolux
