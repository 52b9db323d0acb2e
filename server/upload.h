// One scene on its way from a client to the queue: a header, then chunks without gaps, each with
// its checksum, as many bytes as declared, of the digest declared, and a scene the solver can take.
// What fails on the way leaves nothing behind.
//
// Used by one thread at a time; calls wait for the disk.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "server/job_queue.h"
#include "server/store.h"

namespace isolux {

inline constexpr size_t kMaxChunkBytes = 1 << 20;

class Upload {
 public:
  Upload(Store* store, JobQueue* queue) : store_(store), queue_(queue) {}
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  // Checks every limit before a byte of the scene is taken.
  Status Begin(JobRequest request);
  Status Add(uint64_t offset, std::string_view data, uint64_t checksum);
  // Checks the whole, and queues the job.
  Result<JobQueue::Submitted> Finish();

  // Set after Begin where the request has its job already: no chunks are needed.
  const std::optional<uint64_t>& existing() const { return existing_; }
  bool begun() const { return begun_; }

 private:
  Store* const store_;
  JobQueue* const queue_;
  bool begun_ = false;
  bool has_slot_ = false;
  JobRequest request_;
  std::optional<uint64_t> existing_;
  std::unique_ptr<Store::Incoming> incoming_;
};

}  // namespace isolux
