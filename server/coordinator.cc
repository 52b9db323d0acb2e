#include "server/coordinator.h"

#include "server/job_driver.h"

namespace isolux {

Coordinator::Coordinator(const CoordinatorOptions& options) : options_(options) {}

Result<std::unique_ptr<Coordinator>> Coordinator::Start(const CoordinatorOptions& options) {
  std::unique_ptr<Coordinator> self(new Coordinator(options));
  ASSIGN_OR_RETURN(self->store_, Store::Open(options.data_dir));
  self->sessions_ = std::make_unique<WorkerSessions>(options.sessions);
  self->driver_ =
      std::make_unique<JobDriver>(self->store_.get(), self->sessions_.get(), options.job);
  JobDriver* driver = self->driver_.get();
  self->queue_ = std::make_unique<JobQueue>(
      self->store_.get(),
      [driver](const JobInfo& job, const JobHooks& hooks) { return driver->Run(job, hooks); },
      options.queue);
  self->service_ = std::make_unique<CoordinatorService>(
      self->queue_.get(), self->store_.get(), self->sessions_.get(),
      [driver](const JobInfo& job) { return driver->Latest(job); }, options.service);
  ASSIGN_OR_RETURN(self->server_, GrpcServer::Start(options.server, {self->service_->service(),
                                                                     self->sessions_->service()}));
  RETURN_IF_ERROR(self->queue_->Start());
  self->server_->SetServing(true);
  return self;
}

Coordinator::~Coordinator() { Stop(); }

void Coordinator::Stop() {
  if (stopped_ || server_ == nullptr) return;
  stopped_ = true;
  server_->SetServing(false);
  queue_->Stop();
  sessions_->Shutdown();
  server_->Shutdown(options_.grace_s);
}

}  // namespace isolux
