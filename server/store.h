// What the coordinator keeps on disk, so that a restart loses nothing that was acknowledged.
//
//   DIR/lock                          held while a coordinator uses the folder
//   DIR/index.db                      SQLite: one row a job, the job as its protocol message
//   DIR/scenes/DIGEST.scene           encoded scenes, shared by jobs
//   DIR/jobs/N/snapshot-0001.bin …    encoded snapshots, every round's until the job ends
//   DIR/jobs/N/result.ply             the patch file
//   DIR/incoming/…                    uploads under way; emptied at the start
//
// Files are written to a temporary name, synced and renamed; the index is committed durably after
// the files that it speaks of. May be called from any thread; calls wait for the disk.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/rpc/job_info.h"
#include "common/util/digest.h"
#include "common/util/file.h"
#include "common/util/status.h"

struct sqlite3;

namespace isolux {

class Store {
 public:
  // Makes the folder if need be. kFailedPrecondition when another coordinator uses it.
  static Result<std::unique_ptr<Store>> Open(const std::string& directory);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  // By number.
  Result<std::vector<JobInfo>> LoadJobs();
  // Inserts or replaces; durable on return.
  Status SaveJob(const JobInfo& job);

  // A scene on its way in. What is not kept is removed.
  class Incoming {
   public:
    ~Incoming();
    Incoming(const Incoming&) = delete;
    Incoming& operator=(const Incoming&) = delete;
    Status Append(std::string_view bytes);
    std::string digest() const { return digest_.Finish(); }
    uint64_t size() const { return size_; }
    Result<std::string> Read() const;
    // Makes it the scene of its digest.
    Status Keep();

   private:
    friend class Store;
    Incoming(Store* store, std::string path, int descriptor)
        : store_(store), path_(std::move(path)), descriptor_(descriptor) {}

    Store* const store_;
    std::string path_;  // empty once kept
    int descriptor_;
    uint64_t size_ = 0;
    Digest digest_;
  };
  Result<std::unique_ptr<Incoming>> BeginScene();
  Result<std::string> ReadScene(const std::string& digest) const;

  Status SaveSnapshot(uint64_t job, uint32_t round, const std::string& bytes);
  // Those of rounds 1, 2, … as far as they go without a gap.
  Result<std::vector<std::string>> LoadSnapshots(uint64_t job) const;
  // kNotFound where there is none of this round: its job may have ended.
  Result<std::string> LoadSnapshot(uint64_t job, uint32_t round) const;
  void DropSnapshots(uint64_t job);

  Status SaveResult(uint64_t job, const std::string& bytes);
  // At most `size` bytes from `offset` on.
  Result<std::string> ReadResult(uint64_t job, uint64_t offset, uint64_t size) const;

  uint64_t FreeBytes() const;  // of the file system

 private:
  Store(std::string directory, FileLock lock)
      : directory_(std::move(directory)), lock_(std::move(lock)) {}
  Status OpenIndex();
  std::string JobPath(uint64_t job) const;

  const std::string directory_;
  FileLock lock_;
  std::mutex mutex_;
  sqlite3* index_ = nullptr;     // guarded by mutex_
  uint64_t incoming_count_ = 0;  // guarded by mutex_
};

}  // namespace isolux
