#include "tests/support/local_cluster.h"

#include <utility>

#if defined(__SANITIZE_THREAD__)
// Embree is packaged without the sanitizer's instrumentation: the locks by which its devices share
// state are not seen.
extern "C" const char* __tsan_default_suppressions() { return "race:libembree3.so\n"; }
#endif

namespace isolux::testing {

LocalCluster::LocalCluster(int workers, int threads, const LocalPortLimits& port_limits)
    : port_limits_(port_limits) {
  options_.threads = threads;
  options_.heartbeat_s = 0.02;  // so that a drain is told at once
  for (int i = 0; i < workers; ++i) AddWorker();
}

LocalCluster::~LocalCluster() {
  for (size_t i = 0; i < workers_.size(); ++i) Kill(i);
  for (size_t i = 0; i < workers_.size(); ++i) (void)Join(i);
}

void LocalCluster::AddWorker() {
  auto worker = std::make_unique<Worker>(options_);
  auto [coordinators, workers] = MakeLocalPorts(port_limits_);
  worker->port = std::move(workers);
  const uint64_t id = slots_.size() + 1;
  slots_.push_back({id, fmt::format("w{}", id), std::move(coordinators)});
  worker->thread =
      std::thread([this, w = worker.get()] { w->ended = ServeJobs(*w->port, options_, w->state); });
  workers_.push_back(std::move(worker));
}

void LocalCluster::Kill(size_t worker) {
  slots_[worker].port->Close(Status(StatusCode::kUnavailable, "cut off"));
}

Status LocalCluster::Join(size_t worker) {
  if (workers_[worker]->thread.joinable()) workers_[worker]->thread.join();
  return workers_[worker]->ended;
}

JobInput MakeJobInput(const Scene& scene, const SolveOptions& options) {
  JobInput input;
  input.job = 1;
  input.scene = std::make_shared<const Scene>(scene);
  input.encoded_scene = std::make_shared<const std::string>(Encode(scene));
  input.scene_hash = HashOf(*input.encoded_scene);
  input.options = options;
  return input;
}

Result<SolveResult> RunJob(LocalCluster& cluster, JobInput input, JobCallbacks callbacks,
                           Traffic* traffic) {
  if (!callbacks.workers) callbacks.workers = [&cluster] { return cluster.slots(); };
  JobLimits limits;
  limits.lease_s = 120;  // of a machine that may be busy with other tests
  JobRunner runner(std::move(input), std::move(callbacks), limits);
  Result<SolveResult> result = runner.Run();
  if (traffic != nullptr) *traffic = runner.traffic();
  return result;
}

Result<SolveResult> SolveInProcess(const Scene& scene, const SolveOptions& options, int workers,
                                   int threads) {
  LocalCluster cluster(workers, threads);
  return RunJob(cluster, MakeJobInput(scene, options));
}

std::string BytesWithoutComments(PatchFile patch) {
  patch.comments.clear();
  return Encode(patch);
}

}  // namespace isolux::testing
