// The coordinator as a command sees it: one call a method, errors with a remedy. Watching and
// fetching take up again where a connection broke, for a while.
//
// One thread makes calls; Interrupt may come from another.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/rpc/job_info.h"
#include "common/util/status.h"

namespace isolux {

class Client {
 public:
  // `server` is HOST:PORT. Does not connect yet.
  static Result<std::unique_ptr<Client>> Make(const std::string& server);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  struct Submission {
    std::string request_id;
    std::string name;
    SolveOptions options;
    std::string encoded_scene;
    uint64_t polygons = 0;
    RepairReport repairs;
  };
  struct Submitted {
    uint64_t job = 0;
    bool existing = false;
  };
  Result<Submitted> Submit(const Submission& submission);

  Result<JobInfo> Get(uint64_t job);
  Result<std::vector<JobInfo>> List(uint32_t limit);  // newest first
  Result<JobState> Cancel(uint64_t job);
  Result<JobState> Finish(uint64_t job);
  Result<uint32_t> CountWorkers();

  struct Watcher {
    std::function<void(const RoundSummary&)> on_round;
    std::function<void(const Activity&)> on_activity;
    std::function<void(const std::string&)> on_trouble;  // a connection that is taken up again
  };
  // The job as it ended.
  Result<JobInfo> Watch(uint64_t job, const Watcher& watcher);

  // Writes the result to PATH.part, checks it, renames it. `latest`: of a job that has not ended,
  // its newest snapshot.
  Status Fetch(uint64_t job, const std::string& path, bool latest = false);

  // Ends the call under way, and those to come, with kCancelled; until Resume.
  void Interrupt();
  void Resume();

 private:
  class Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A name for a request that nobody else will choose.
std::string MakeRequestId();

}  // namespace isolux
