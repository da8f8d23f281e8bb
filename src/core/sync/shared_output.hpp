// SharedOutput<Input>: several inputs, each with a thread of its own, push to one output in turn.
#pragma once
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace weir::sync {

// The input that pushed last is the active one. A thread that waits for the output leaves as soon
// as its input is closed, so that an input can flush, stop and go away while another one blocks in
// the output. While the output flushes for one input, the others wait. Input() stands for no input.
template <class Input>
class SharedOutput {
 public:
  enum class Access {
    Denied,    // the input is closed
    Granted,   // and the input was the active one already; call release()
    Switched,  // and the input has become the active one; call release()
  };

  // An input is closed until open(), and from close() on: while it is inactive or flushes.
  void open(const Input& input) {
    std::lock_guard lock(mutex_);
    if (!is_open(input)) open_.push_back(input);
  }
  void close(const Input& input) {
    std::lock_guard lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
  }

  // Waits until no other input uses the output. False: the input is closed.
  [[nodiscard]] bool acquire(const Input& input) {
    std::unique_lock lock(mutex_);
    return wait_for_turn(lock, input);
  }
  // The same, and the input becomes the active one.
  Access acquire_as_active(const Input& input) {
    std::unique_lock lock(mutex_);
    if (!wait_for_turn(lock, input)) return Access::Denied;
    return std::exchange(active_, input) == input ? Access::Granted : Access::Switched;
  }
  void release() {
    std::lock_guard lock(mutex_);
    in_use_ = false;
    changed_.notify_all();
  }

  // The input flushes from here on. True where it is active: then send FLUSH_START downstream and
  // call flush_sent().
  [[nodiscard]] bool flush_start(const Input& input) {
    std::unique_lock lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
    wait_for_sender(lock);
    if (!(active_ == input) || flushing_ == input) return false;
    flushing_ = input;
    sender_ = std::this_thread::get_id();
    return true;
  }
  // True where the output flushes for this input: then send FLUSH_STOP downstream and call
  // flush_sent(). The caller calls open() when the input takes buffers again.
  [[nodiscard]] bool flush_stop(const Input& input) {
    std::unique_lock lock(mutex_);
    wait_for_sender(lock);
    if (flushing_ == Input() || !(flushing_ == input)) return false;
    sender_ = std::this_thread::get_id();
    stops_flush_ = true;
    return true;
  }
  // FLUSH_START and FLUSH_STOP go downstream in the order in which they were decided.
  void flush_sent() {
    std::lock_guard lock(mutex_);
    if (std::exchange(stops_flush_, false)) flushing_ = Input();
    sender_.reset();
    changed_.notify_all();
  }

  // The input goes away, after close() and the end of its thread. True where it was active.
  bool remove(const Input& input) {
    std::lock_guard lock(mutex_);
    std::erase(open_, input);
    changed_.notify_all();
    const bool was_active = active_ == input;
    if (was_active) active_ = Input();
    return was_active;
  }
  // No input is active and nothing flushes; open inputs stay open.
  void reset() {
    std::lock_guard lock(mutex_);
    active_ = flushing_ = Input();
    changed_.notify_all();
  }

  Input active() const {
    std::lock_guard lock(mutex_);
    return active_;
  }
  size_t waiting() const {  // threads in acquire()
    std::lock_guard lock(mutex_);
    return waiting_;
  }

 private:
  using Lock = std::unique_lock<std::mutex>;

  bool is_open(const Input& input) const {
    return std::find(open_.begin(), open_.end(), input) != open_.end();
  }
  // False: the input is closed.
  bool wait_for_turn(Lock& lock, const Input& input) {
    const auto is_free = [this] { return !in_use_ && flushing_ == Input(); };
    ++waiting_;
    changed_.wait(lock, [&] { return !is_open(input) || is_free(); });
    --waiting_;
    if (!is_open(input)) return false;
    return in_use_ = true;
  }
  void wait_for_sender(Lock& lock) {
    changed_.wait(lock, [this] { return !sender_ || *sender_ == std::this_thread::get_id(); });
  }

  mutable std::mutex mutex_;  // guards everything below; never held while the output is used
  std::condition_variable changed_;
  std::vector<Input> open_;
  Input active_{}, flushing_{};
  bool in_use_ = false, stops_flush_ = false;
  std::optional<std::thread::id> sender_;  // of FLUSH_START or FLUSH_STOP
  size_t waiting_ = 0;
};

}  // namespace weir::sync
