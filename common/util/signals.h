// SIGINT and SIGTERM, taken by a thread of their own instead of interrupting others.
#pragma once

#include <functional>
#include <thread>

namespace isolux {

// First thing in main, before any thread is started: all threads inherit it. Ignores SIGPIPE too.
void BlockTerminationSignals();
// In a child between fork and exec: the mask is inherited there as well.
void UnblockTerminationSignals();

// Calls `on_signal` with 1 for the first signal, 2 for the second, on a thread of its own.
class SignalWatcher {
 public:
  explicit SignalWatcher(std::function<void(int)> on_signal);
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

 private:
  std::thread thread_;
};

}  // namespace isolux
