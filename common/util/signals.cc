#include "common/util/signals.h"

#include <csignal>
#include <utility>

namespace isolux {
namespace {

// Wakes the watcher to end it. Blocked with the others; the default action is to be ignored.
constexpr int kWake = SIGURG;

sigset_t Signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, kWake);
  return set;
}

}  // namespace

void BlockTerminationSignals() {
  const sigset_t set = Signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

void UnblockTerminationSignals() {
  const sigset_t set = Signals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

SignalWatcher::SignalWatcher(std::function<void(int)> on_signal) {
  thread_ = std::thread([on_signal = std::move(on_signal)] {
    const sigset_t set = Signals();
    int count = 0;
    int signal = 0;
    while (sigwait(&set, &signal) == 0 && signal != kWake) on_signal(++count);
  });
}

SignalWatcher::~SignalWatcher() {
  pthread_kill(thread_.native_handle(), kWake);
  thread_.join();
}

}  // namespace isolux
