// Files as the coordinator and the client need them: whole, written so that a crash leaves either
// the old one or the new one, and temporary folders that do not stay behind.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "common/util/status.h"

namespace isolux {

// Fails where the file is larger than `limit_bytes`.
Result<std::string> ReadFile(const std::string& path, uint64_t limit_bytes = 1ULL << 34);

// Written to PATH.part, synced, renamed; the folder is synced too. The name appears whole or not at
// all.
Status WriteFileDurably(const std::string& path, const std::string& bytes);

// Flushes what was written to a folder: names made, renamed or removed.
Status SyncDirectory(const std::string& path);
// With its parents; no error when it exists.
Status MakeDirectories(const std::string& path);

// Held as long as it lives; another process (or another lock here) cannot take it meanwhile.
class FileLock {
 public:
  // kFailedPrecondition when somebody else has it.
  static Result<FileLock> Take(const std::string& path);
  FileLock(FileLock&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  FileLock& operator=(FileLock&& other) noexcept;
  ~FileLock();

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

// A new empty folder under TMPDIR (or /tmp), removed with all that is in it.
class TemporaryDirectory {
 public:
  static Result<TemporaryDirectory> Make(const std::string& prefix);
  TemporaryDirectory(TemporaryDirectory&& other) noexcept : path_(std::move(other.path_)) {
    other.path_.clear();
  }
  TemporaryDirectory& operator=(TemporaryDirectory&& other) noexcept;
  ~TemporaryDirectory();

  const std::string& path() const { return path_; }
  // Its path; somebody else removes it.
  std::string Keep() { return std::exchange(path_, std::string()); }

 private:
  explicit TemporaryDirectory(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace isolux
