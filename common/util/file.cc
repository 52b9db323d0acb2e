#include "common/util/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace isolux {
namespace {

std::string Why() { return std::strerror(errno); }

// Closes on every way out.
struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

Status WriteAll(int descriptor, const std::string& bytes, const std::string& path) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t wrote = ::write(descriptor, bytes.data() + done, bytes.size() - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) {
      return MakeStatus(StatusCode::kUnavailable, "{}: cannot be written: {}", path, Why());
    }
    done += static_cast<size_t>(wrote);
  }
  return {};
}

}  // namespace

Result<std::string> ReadFile(const std::string& path, uint64_t limit_bytes) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat info {};
  if (file.number < 0 || ::fstat(file.number, &info) != 0) {
    const auto code = errno == ENOENT ? StatusCode::kNotFound : StatusCode::kPermissionDenied;
    return Error(code, "{}: cannot be read: {}", path, Why());
  }
  if (!S_ISREG(info.st_mode)) return Error(StatusCode::kInvalidArgument, "{}: not a file", path);
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > limit_bytes) {
    return Error(StatusCode::kResourceExhausted, "{}: {} bytes; {} is the limit", path, size,
                 limit_bytes);
  }
  std::string bytes(size, '\0');
  size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(file.number, bytes.data() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Error(StatusCode::kDataLoss, "{}: cannot be read: {}", path, Why());
    if (got == 0) return Error(StatusCode::kDataLoss, "{}: ends after {} bytes", path, done);
    done += static_cast<size_t>(got);
  }
  return bytes;
}

Status WriteFileDurably(const std::string& path, const std::string& bytes) {
  const std::string part = path + ".part";
  Status status;
  {
    const Descriptor file{::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (file.number < 0) {
      return MakeStatus(StatusCode::kPermissionDenied, "{}: cannot be written: {}", path, Why());
    }
    status = WriteAll(file.number, bytes, path);
    if (status.ok() && ::fsync(file.number) != 0) {
      status = MakeStatus(StatusCode::kUnavailable, "{}: cannot be synced: {}", path, Why());
    }
  }
  if (status.ok() && ::rename(part.c_str(), path.c_str()) != 0) {
    status = MakeStatus(StatusCode::kUnavailable, "{}: cannot be named: {}", path, Why());
  }
  if (!status.ok()) {
    ::unlink(part.c_str());
    return status;
  }
  return SyncDirectory(std::filesystem::path(path).parent_path().string());
}

Status SyncDirectory(const std::string& path) {
  const Descriptor folder{::open(path.empty() ? "." : path.c_str(), O_RDONLY | O_CLOEXEC)};
  // Some file systems cannot sync folders: no reason to fail.
  if (folder.number < 0 || (::fsync(folder.number) != 0 && errno != EINVAL && errno != EROFS)) {
    return MakeStatus(StatusCode::kUnavailable, "{}: cannot be synced: {}", path, Why());
  }
  return {};
}

Status MakeDirectories(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    return MakeStatus(StatusCode::kPermissionDenied, "{}: cannot be made: {}", path,
                      error.message());
  }
  return {};
}

Result<FileLock> FileLock::Take(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    return Error(StatusCode::kPermissionDenied, "{}: cannot be opened: {}", path, Why());
  }
  FileLock lock(descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Error(StatusCode::kFailedPrecondition, "{}: another process holds it", path);
  }
  return lock;
}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<TemporaryDirectory> TemporaryDirectory::Make(const std::string& prefix) {
  const char* root = std::getenv("TMPDIR");
  std::string path =
      std::string(root != nullptr && *root != '\0' ? root : "/tmp") + "/" + prefix + "XXXXXX";
  if (::mkdtemp(path.data()) == nullptr) {
    return Error(StatusCode::kPermissionDenied,
                 "{}: cannot be made: {}; set TMPDIR to a folder that can be written", path, Why());
  }
  return TemporaryDirectory(path);
}

TemporaryDirectory& TemporaryDirectory::operator=(TemporaryDirectory&& other) noexcept {
  std::swap(path_, other.path_);
  return *this;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;  // nothing more can be done about it
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace isolux
