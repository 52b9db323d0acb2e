// The clients' calls: each is converted, handed to the queue or the store, and the answer converted
// back; nothing is decided here. What waits for the disk is done by an executor's threads.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/job_queue.h"
#include "server/store.h"
#include "server/worker_sessions.h"

namespace grpc {
class Service;
}

namespace isolux {

class CoordinatorService {
 public:
  struct Options {
    double idle_upload_s = 60;  // without a chunk, after which an upload is ended
    int threads = 3;
  };

  // Makes a patch file of a job that still runs.
  using Latest = std::function<Result<std::string>(const JobInfo&)>;

  CoordinatorService(JobQueue* queue, Store* store, const WorkerSessions* workers, Latest latest,
                     Options options);
  ~CoordinatorService();  // after the gRPC server is gone
  CoordinatorService(const CoordinatorService&) = delete;
  CoordinatorService& operator=(const CoordinatorService&) = delete;

  // To be registered with the gRPC server.
  grpc::Service* service();

 private:
  class Service;
  std::unique_ptr<Service> service_;
};

}  // namespace isolux
