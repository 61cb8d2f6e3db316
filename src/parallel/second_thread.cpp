#include "parallel/second_thread.h"

namespace predictive_stereo {

SecondThread::~SecondThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

SecondThread::Running SecondThread::start(std::function<void()> task) {
  std::packaged_task<void()> packaged(std::move(task));
  Running running(packaged.get_future());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    task_ = std::move(packaged);
  }
  if (!thread_.joinable()) thread_ = std::thread([this] { runTasks(); });
  changed_.notify_one();
  return running;
}

void SecondThread::runTasks() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopped_ || task_.valid(); });
    if (stopped_) return;
    std::packaged_task<void()> task = std::move(task_);
    lock.unlock();
    task();
    lock.lock();
  }
}

}  // namespace predictive_stereo
