#include "common/util/parallel.h"

#include <algorithm>
#include <ctime>

namespace isolux {

double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

ThreadPool::ThreadPool(int thread_count) {
  if (thread_count <= 0) thread_count = static_cast<int>(std::thread::hardware_concurrency());
  for (int i = 1; i < std::max(1, thread_count); ++i) {
    threads_.emplace_back([this, i] { Run(i); });
  }
}

ThreadPool::~ThreadPool() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
  }
  start_.notify_all();
  for (auto& thread : threads_) thread.join();
}

double ThreadPool::CpuSeconds() const {
  std::lock_guard lock(mutex_);
  return cpu_seconds_;
}

void ThreadPool::For(size_t count, size_t grain,
                     const std::function<void(size_t, size_t, int)>& body) {
  if (count == 0) return;
  {
    std::lock_guard lock(mutex_);
    body_ = &body;
    count_ = count;
    grain_ = std::max<size_t>(1, grain);
    next_ = 0;
    ++generation_;
  }
  if (count > grain) start_.notify_all();
  Work(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
  body_ = nullptr;
}

void ThreadPool::Run(int thread) {
  uint64_t seen = 0;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      start_.wait(lock, [&] { return stop_ || (generation_ != seen && body_ != nullptr); });
      if (stop_) return;
      seen = generation_;
    }
    Work(thread);
  }
}

void ThreadPool::Work(int thread) {
  const double start = ThreadCpuSeconds();
  std::unique_lock lock(mutex_);
  ++busy_;
  while (body_ != nullptr && next_ < count_) {
    const size_t begin = next_;
    const size_t end = std::min(count_, begin + grain_);
    next_ = end;
    const auto* body = body_;
    lock.unlock();
    (*body)(begin, end, thread);
    lock.lock();
  }
  --busy_;
  if (thread != 0) cpu_seconds_ += ThreadCpuSeconds() - start;
  if (busy_ == 0) done_.notify_all();
}

}  // namespace isolux
