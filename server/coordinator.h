// A whole coordinator: store, queue, sessions, services and server, started and stopped in the
// right order.
#pragma once

#include <memory>
#include <string>

#include "common/util/status.h"
#include "server/coordinator_service.h"
#include "server/grpc_server.h"
#include "server/job.h"
#include "server/job_queue.h"
#include "server/worker_sessions.h"

namespace isolux {

struct CoordinatorOptions {
  std::string data_dir;
  GrpcServerOptions server;
  WorkerSessions::Options sessions;
  JobQueue::Limits queue;
  CoordinatorService::Options service;
  JobLimits job;
  double grace_s = 1.5;  // for calls under way when it stops
};

class JobDriver;

class Coordinator {
 public:
  static Result<std::unique_ptr<Coordinator>> Start(const CoordinatorOptions& options);
  ~Coordinator();

  const std::string& address() const { return server_->address(); }
  int port() const { return server_->port(); }

  // Refuses new work, stops the job that runs (it goes on at the next start), ends all calls.
  void Stop();

 private:
  explicit Coordinator(const CoordinatorOptions& options);

  const CoordinatorOptions options_;
  bool stopped_ = false;
  // In the order in which they are made; taken down in reverse.
  std::unique_ptr<Store> store_;
  std::unique_ptr<WorkerSessions> sessions_;
  std::unique_ptr<JobDriver> driver_;
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorService> service_;
  std::unique_ptr<GrpcServer> server_;
};

}  // namespace isolux
