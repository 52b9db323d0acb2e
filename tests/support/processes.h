// Real programs on loopback, for tests: a coordinator, workers, and commands that are run to their
// end. Everything is killed and removed when the object goes.
#pragma once

#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/client.h"
#include "common/util/file.h"
#include "common/util/process.h"

namespace isolux::testing {

struct CommandResult {
  int code = -1;
  std::string output;  // standard output
  std::string error;   // standard error

  nlohmann::json Json() const { return nlohmann::json::parse(output, nullptr, false); }
};

class Programs {
 public:
  Programs();
  ~Programs();  // prints what the programs said if the test has failed

  // A folder of the test's own; programs use it as TMPDIR's parent and for their logs.
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }
  // What the programs left in the folder for temporary files.
  std::vector<std::string> TemporaryFiles() const;

  // Returns once it listens. `extra`: more flags.
  void StartServer(const std::vector<std::string>& extra = {},
                   const std::string& listen = "127.0.0.1:0");
  ChildProcess& server() { return server_.back(); }
  const std::string& address() const { return address_; }
  std::string ServerLog() const;

  // Returns once it is connected.
  ChildProcess& StartWorker(int threads = 1);
  ChildProcess& worker(size_t i) { return workers_.at(i); }
  // Waits until so many are connected.
  void WaitForWorkers(uint32_t count);

  // Any program, to its end. The name of a binary of ours, then its arguments.
  CommandResult Run(const std::vector<std::string>& arguments);
  ChildProcess Start(const std::vector<std::string>& arguments, const std::string& log);
  // isolux COMMAND … --server ADDRESS.
  CommandResult Isolux(std::vector<std::string> arguments);

  Client& client() { return *client_; }
  // Polls until the job has told so many rounds, or has ended.
  JobInfo WaitForRounds(uint64_t job, size_t rounds);
  JobInfo WaitForEnd(uint64_t job);

 private:
  TemporaryDirectory folder_;
  std::string address_;
  std::deque<ChildProcess> server_;  // the last one counts
  std::deque<ChildProcess> workers_;
  std::unique_ptr<Client> client_;
  int runs_ = 0;
};

// A scene of the project's own.
std::string ScenePath(const std::string& name);

// A patch file without its comments: what must not depend on how it was computed.
std::string Physics(const std::string& path);

}  // namespace isolux::testing
