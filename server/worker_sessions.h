// The workers that are connected: each a stream, seen from here as a MessagePort.
//
// A worker of another build or instruction set is refused when it says hello. A worker that is
// silent for longer than the lease, or whose stream ends, is gone: its port fails, and it is no
// longer among the connected ones. One that comes back is a new one, with a new number.
//
// Threads: everything here may be called from any thread. gRPC's own threads only move frames
// between the stream and the port; they never wait.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/rpc/message_port.h"
#include "common/rpc/stream_port.h"
#include "common/util/status.h"

namespace grpc {
class Service;
}

namespace isolux {

struct ConnectedWorker {
  uint64_t id = 0;  // of the connection
  std::string name;
  uint32_t threads = 1;
  std::shared_ptr<MessagePort> port;
};

class WorkerSessions {
 public:
  struct Options {
    double heartbeat_s = 2;  // asked of the workers
    double lease_s = 10;     // of silence, after which a worker is given up
    uint32_t max_workers = 256;
    StreamPort::Limits port;
  };

  explicit WorkerSessions(Options options);
  ~WorkerSessions();  // after the gRPC server is gone
  WorkerSessions(const WorkerSessions&) = delete;
  WorkerSessions& operator=(const WorkerSessions&) = delete;

  // To be registered with the gRPC server.
  grpc::Service* service();

  std::vector<ConnectedWorker> Connected() const;
  // Waits until one is connected, at most so long; whether one is.
  bool WaitForWorker(double timeout_s) const;

  // Ends a connection: in order (what was sent still arrives), or at once.
  void Release(uint64_t id);
  void Drop(uint64_t id, const Status& why);

  // Refuses workers from now on and ends the connections there are.
  void Shutdown();

 private:
  class Service;
  class Reactor;
  // One stream, from its first byte on.
  struct Session {
    ConnectedWorker worker;  // its name and threads are known once it is admitted
    std::shared_ptr<StreamPort> port;
    std::chrono::steady_clock::time_point since;
    bool admitted = false;
  };

  // Called by the reactors: a stream begins, says hello, ends.
  uint64_t Add(std::shared_ptr<StreamPort> port);
  Status Admit(uint64_t id, const std::string& name, uint32_t threads);
  void Remove(uint64_t id);
  void CheckLeases();  // own thread

  const Options options_;
  std::unique_ptr<Service> service_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  // Guarded by mutex_.
  std::map<uint64_t, Session> sessions_;
  uint64_t last_id_ = 0;
  bool stopping_ = false;
  bool ended_ = false;

  std::thread ticker_;
};

}  // namespace isolux
