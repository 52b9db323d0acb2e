// A coordinator and workers of one's own: child processes on loopback, on a free port, with a
// temporary data folder. All of it is gone with this object, and with this process, however it
// ends.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/client.h"
#include "common/util/file.h"
#include "common/util/process.h"
#include "common/util/status.h"

namespace isolux {

class LocalCluster {
 public:
  struct Options {
    int workers = 1;
    int threads = 0;                 // of each worker; 0: the cores shared out among them
    std::string log_level = "warn";  // of all of them, to our standard error
  };

  // Returns once all workers are connected.
  static Result<std::unique_ptr<LocalCluster>> Start(const Options& options);
  ~LocalCluster();
  LocalCluster(const LocalCluster&) = delete;
  LocalCluster& operator=(const LocalCluster&) = delete;

  Client& client() { return *client_; }

  // Ends all processes in order; what does not end in time is killed.
  void Stop();

 private:
  explicit LocalCluster(TemporaryDirectory folder) : folder_(std::move(folder)) {}
  Status StartServer(const Options& options);
  Status StartWorkers(const Options& options);

  TemporaryDirectory folder_;
  std::string address_;
  std::vector<ChildProcess> server_;  // one, once started
  std::vector<ChildProcess> workers_;
  std::unique_ptr<Client> client_;
};

}  // namespace isolux
