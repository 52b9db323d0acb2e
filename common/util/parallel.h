// A fixed set of threads and one loop over them. Results must not depend on which thread ran what:
// callers write to their own slots, or sum exact integers.
//
// Plain std::thread and mutexes rather than TBB: the loops here are coarse, and the thread
// sanitizer sees through every synchronisation.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isolux {

class ThreadPool {
 public:
  // `thread_count` threads take part in a loop, the caller among them; 0 means one a core.
  explicit ThreadPool(int thread_count);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const { return static_cast<int>(threads_.size()) + 1; }

  // Calls body(begin, end, thread) for chunks of at most `grain` indices that together cover
  // [0, count), each once; thread is in [0, thread_count()). Returns when all are done. One loop at
  // a time: not to be called from within a body.
  void For(size_t count, size_t grain, const std::function<void(size_t, size_t, int)>& body);

  // CPU seconds that the threads besides the caller's have spent inside loops so far.
  double CpuSeconds() const;

 private:
  void Run(int thread);
  void Work(int thread);

  std::vector<std::thread> threads_;
  mutable std::mutex mutex_;
  std::condition_variable start_, done_;
  // Guarded by mutex_.
  const std::function<void(size_t, size_t, int)>* body_ = nullptr;
  size_t count_ = 0, grain_ = 1, next_ = 0;
  int busy_ = 0;
  uint64_t generation_ = 0;
  bool stop_ = false;
  double cpu_seconds_ = 0;
};

// CPU seconds of the calling thread.
double ThreadCpuSeconds();

}  // namespace isolux
