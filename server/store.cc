#include "server/store.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "common/rpc/convert.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr int kSchemaVersion = 1;
constexpr uint32_t kMaxSnapshots = 10'000;

Status IndexError(sqlite3* index, const char* what) {
  return MakeStatus(StatusCode::kUnavailable, "the index of jobs cannot {}: {}", what,
                    index != nullptr ? sqlite3_errmsg(index) : "out of memory");
}

Status Execute(sqlite3* index, const char* sql) {
  if (sqlite3_exec(index, sql, nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return IndexError(index, "be set up");
}

// Finalizes on every way out.
struct Statement {
  sqlite3_stmt* handle = nullptr;
  ~Statement() { sqlite3_finalize(handle); }
};

}  // namespace

Result<std::unique_ptr<Store>> Store::Open(const std::string& directory) {
  for (const char* part : {"", "/scenes", "/jobs", "/incoming"}) {
    RETURN_IF_ERROR(MakeDirectories(directory + part));
  }
  Result<FileLock> lock = FileLock::Take(directory + "/lock");
  if (!lock) {
    if (lock.error().code() != StatusCode::kFailedPrecondition) {
      return tl::unexpected<Status>(lock.error());
    }
    return Error(StatusCode::kFailedPrecondition,
                 "{}: another isolux-server uses this folder; give each its own --data-dir",
                 directory);
  }
  std::error_code ignored;  // leftovers are harmless
  for (const auto& entry : fs::directory_iterator(directory + "/incoming", ignored)) {
    fs::remove(entry.path(), ignored);
  }
  std::unique_ptr<Store> store(new Store(directory, std::move(*lock)));
  RETURN_IF_ERROR(store->OpenIndex());
  return store;
}

Store::~Store() { sqlite3_close(index_); }

Status Store::OpenIndex() {
  const std::string path = directory_ + "/index.db";
  if (sqlite3_open(path.c_str(), &index_) != SQLITE_OK) return IndexError(index_, "be opened");
  sqlite3_busy_timeout(index_, 5000);
  RETURN_IF_ERROR(Execute(index_, "PRAGMA journal_mode=WAL"));
  RETURN_IF_ERROR(Execute(index_, "PRAGMA synchronous=FULL"));
  Statement version;
  if (sqlite3_prepare_v2(index_, "PRAGMA user_version", -1, &version.handle, nullptr) !=
          SQLITE_OK ||
      sqlite3_step(version.handle) != SQLITE_ROW) {
    return IndexError(index_, "be read").Within(path);
  }
  const int found = sqlite3_column_int(version.handle, 0);
  if (found == kSchemaVersion) return {};
  if (found != 0) {
    return MakeStatus(StatusCode::kFailedPrecondition,
                      "{}: written by another version of isolux-server (format {}, this one knows "
                      "{}): use that version, or another --data-dir",
                      path, found, kSchemaVersion);
  }
  return Execute(index_,
                 "BEGIN;"
                 "CREATE TABLE jobs ("
                 "  id INTEGER PRIMARY KEY,"
                 "  request_id TEXT NOT NULL UNIQUE,"
                 "  state TEXT NOT NULL,"
                 "  name TEXT NOT NULL,"
                 "  record BLOB NOT NULL"  // isolux.v1.Job
                 ") STRICT;"
                 "PRAGMA user_version=1;"
                 "COMMIT;");
}

Result<std::vector<JobInfo>> Store::LoadJobs() {
  std::lock_guard lock(mutex_);
  Statement select;
  if (sqlite3_prepare_v2(index_, "SELECT id, record FROM jobs ORDER BY id", -1, &select.handle,
                         nullptr) != SQLITE_OK) {
    return tl::unexpected<Status>(IndexError(index_, "be read"));
  }
  std::vector<JobInfo> jobs;
  int step;
  while ((step = sqlite3_step(select.handle)) == SQLITE_ROW) {
    v1::Job message;
    if (!message.ParseFromArray(sqlite3_column_blob(select.handle, 1),
                                sqlite3_column_bytes(select.handle, 1))) {
      return Error(StatusCode::kDataLoss, "{}/index.db: job {} is damaged", directory_,
                   sqlite3_column_int64(select.handle, 0));
    }
    ASSIGN_OR_RETURN(auto job, FromProto(message));
    jobs.push_back(std::move(job));
  }
  if (step != SQLITE_DONE) return tl::unexpected<Status>(IndexError(index_, "be read"));
  return jobs;
}

Status Store::SaveJob(const JobInfo& job) {
  const std::string record = ToProto(job, /*whole=*/true).SerializeAsString();
  std::lock_guard lock(mutex_);
  Statement insert;
  if (sqlite3_prepare_v2(index_,
                         "INSERT INTO jobs (id, request_id, state, name, record)"
                         " VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT (id) DO UPDATE"
                         " SET state=excluded.state, record=excluded.record",
                         -1, &insert.handle, nullptr) != SQLITE_OK) {
    return IndexError(index_, "be written");
  }
  sqlite3_bind_int64(insert.handle, 1, static_cast<int64_t>(job.id));
  sqlite3_bind_text(insert.handle, 2, job.request_id.c_str(), -1, SQLITE_STATIC);
  sqlite3_bind_text(insert.handle, 3, ToText(job.state), -1, SQLITE_STATIC);
  sqlite3_bind_text(insert.handle, 4, job.name.c_str(), -1, SQLITE_STATIC);
  sqlite3_bind_blob64(insert.handle, 5, record.data(), record.size(), SQLITE_STATIC);
  if (sqlite3_step(insert.handle) != SQLITE_DONE) return IndexError(index_, "be written");
  return {};
}

Result<std::unique_ptr<Store::Incoming>> Store::BeginScene() {
  uint64_t number;
  {
    std::lock_guard lock(mutex_);
    number = ++incoming_count_;
  }
  const std::string path = directory_ + "/incoming/" + std::to_string(number);
  const int descriptor =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    return Error(StatusCode::kUnavailable, "{}: cannot be written: {}", path, std::strerror(errno));
  }
  return std::unique_ptr<Incoming>(new Incoming(this, path, descriptor));
}

Store::Incoming::~Incoming() {
  ::close(descriptor_);
  if (!path_.empty()) ::unlink(path_.c_str());
}

Status Store::Incoming::Append(std::string_view bytes) {
  digest_.Add(bytes);
  size_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t wrote = ::write(descriptor_, bytes.data(), bytes.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) {
      return MakeStatus(StatusCode::kUnavailable, "the scene cannot be stored: {}",
                        std::strerror(errno));
    }
    bytes.remove_prefix(static_cast<size_t>(wrote));
  }
  return {};
}

Result<std::string> Store::Incoming::Read() const { return ReadFile(path_); }

Status Store::Incoming::Keep() {
  const std::string folder = store_->directory_ + "/scenes";
  const std::string path = folder + "/" + digest() + ".scene";
  if (::fsync(descriptor_) != 0 || ::rename(path_.c_str(), path.c_str()) != 0) {
    return MakeStatus(StatusCode::kUnavailable, "{}: cannot be stored: {}", path,
                      std::strerror(errno));
  }
  path_.clear();
  return SyncDirectory(folder);
}

Result<std::string> Store::ReadScene(const std::string& digest) const {
  return ReadFile(directory_ + "/scenes/" + digest + ".scene");
}

std::string Store::JobPath(uint64_t job) const {
  return directory_ + "/jobs/" + std::to_string(job);
}

Status Store::SaveSnapshot(uint64_t job, uint32_t round, const std::string& bytes) {
  RETURN_IF_ERROR(MakeDirectories(JobPath(job)));
  return WriteFileDurably(JobPath(job) + fmt::format("/snapshot-{:04}.bin", round), bytes);
}

Result<std::vector<std::string>> Store::LoadSnapshots(uint64_t job) const {
  std::vector<std::string> snapshots;
  for (uint32_t round = 1; round <= kMaxSnapshots; ++round) {
    Result<std::string> bytes = LoadSnapshot(job, round);
    if (!bytes && bytes.error().code() == StatusCode::kNotFound) break;
    if (!bytes) return tl::unexpected<Status>(bytes.error());
    snapshots.push_back(std::move(*bytes));
  }
  return snapshots;
}

Result<std::string> Store::LoadSnapshot(uint64_t job, uint32_t round) const {
  return ReadFile(JobPath(job) + fmt::format("/snapshot-{:04}.bin", round));
}

void Store::DropSnapshots(uint64_t job) {
  std::error_code ignored;  // space is lost, nothing else
  for (const auto& entry : fs::directory_iterator(JobPath(job), ignored)) {
    if (entry.path().filename().string().starts_with("snapshot-")) {
      fs::remove(entry.path(), ignored);
    }
  }
}

Status Store::SaveResult(uint64_t job, const std::string& bytes) {
  RETURN_IF_ERROR(MakeDirectories(JobPath(job)));
  return WriteFileDurably(JobPath(job) + "/result.ply", bytes);
}

Result<std::string> Store::ReadResult(uint64_t job, uint64_t offset, uint64_t size) const {
  const std::string path = JobPath(job) + "/result.ply";
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return Error(StatusCode::kDataLoss, "{}: cannot be read: {}", path, std::strerror(errno));
  }
  std::string bytes(size, '\0');
  size_t done = 0;
  ssize_t got = 1;
  while (done < size && got > 0) {
    got = ::pread(descriptor, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR)
      got = 1;
    else if (got > 0)
      done += static_cast<size_t>(got);
  }
  ::close(descriptor);
  if (got < 0) return Error(StatusCode::kDataLoss, "{}: cannot be read", path);
  bytes.resize(done);
  return bytes;
}

uint64_t Store::FreeBytes() const {
  struct statvfs info {};
  if (::statvfs(directory_.c_str(), &info) != 0) return 0;
  return static_cast<uint64_t>(info.f_bavail) * info.f_frsize;
}

}  // namespace isolux
