#include "client/local_cluster.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

namespace isolux {
namespace {

constexpr double kStartS = 60;    // for the server to listen, and for the workers to connect
constexpr double kGoodbyeS = 10;  // for the server to stop

}  // namespace

Result<std::unique_ptr<LocalCluster>> LocalCluster::Start(const Options& options) {
  ASSIGN_OR_RETURN(auto folder, TemporaryDirectory::Make("isolux-solve-"));
  std::unique_ptr<LocalCluster> cluster(new LocalCluster(std::move(folder)));
  RETURN_IF_ERROR(cluster->StartServer(options));
  ASSIGN_OR_RETURN(cluster->client_, Client::Make(cluster->address_));
  RETURN_IF_ERROR(cluster->StartWorkers(options));
  return cluster;
}

Status LocalCluster::StartServer(const Options& options) {
  ChildProcess::Options child;
  // In order, so that it removes its folder even when this process is killed.
  child.death_signal = SIGTERM;
  child.pipe_output = true;
  ASSIGN_OR_RETURN(auto server,
                   ChildProcess::Start({ProgramBeside("isolux-server"), "--listen", "127.0.0.1:0",
                                        "--port-file", "-", "--data-dir", folder_.path(),
                                        "--temporary", "--log-level", options.log_level},
                                       child));
  server_.push_back(std::move(server));
  const Result<std::string> port = server_[0].ReadLine(kStartS);
  if (!port) {
    return MakeStatus(StatusCode::kUnavailable, "isolux-server did not start: {}",
                      port.error().message());
  }
  address_ = "127.0.0.1:" + *port;
  return {};
}

Status LocalCluster::StartWorkers(const Options& options) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int threads = options.threads > 0 ? options.threads : std::max(1, cores / options.workers);
  for (int i = 1; i <= options.workers; ++i) {
    ASSIGN_OR_RETURN(
        auto worker,
        ChildProcess::Start({ProgramBeside("isolux-worker"), "--server", address_, "--threads",
                             std::to_string(threads), "--name", "local-" + std::to_string(i),
                             "--log-level", options.log_level},
                            ChildProcess::Options()));
    workers_.push_back(std::move(worker));
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kStartS);
  while (std::chrono::steady_clock::now() < end) {
    for (ChildProcess& worker : workers_) {
      if (!worker.Running()) {
        return MakeStatus(StatusCode::kUnavailable, "a worker ended at its start with code {}",
                          worker.exit_code());
      }
    }
    ASSIGN_OR_RETURN(const uint32_t connected, client_->CountWorkers());
    if (connected >= workers_.size()) return {};
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return MakeStatus(StatusCode::kUnavailable, "the workers did not connect within {} s", kStartS);
}

void LocalCluster::Stop() {
  // The server would wait for our connection, on which nobody answers between two calls.
  client_.reset();
  // They hold nothing that anybody needs.
  for (ChildProcess& worker : workers_) worker.Signal(SIGKILL);
  for (ChildProcess& worker : workers_) worker.Wait(kGoodbyeS);
  for (ChildProcess& server : server_) server.Signal(SIGTERM);
  for (ChildProcess& server : server_) server.Wait(kGoodbyeS);
  workers_.clear();
  server_.clear();
}

LocalCluster::~LocalCluster() { Stop(); }

}  // namespace isolux
