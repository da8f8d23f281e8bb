// PairedTensors<Item>: a sink pad of results that are paired with the pictures of another pad, by
// the newest or by the same running time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <memory>

#include "core/sync/newest.hpp"
#include "core/sync/timed_queue.hpp"
#include "gstcpp/element/property.hpp"
#include "gstcpp/pads/timed_tensors.hpp"

namespace weir {

enum class ResultsSync : int32_t { Newest, SameTime };

namespace gst {

template <>
struct EnumType<ResultsSync> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "The newest available results; pictures never wait", "newest"},
        {1, "Each picture waits for the results of its own time", "same-time"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirOverlaySync", values);
    return t;
  }
};

template <class Item>
class PairedTensors : public TimedTensors {
 public:
  using Results = std::shared_ptr<const Item>;

  // Call before a stream starts.
  void start(ResultsSync sync) {
    sync_ = sync;
    newest_.reset();
    queue_.clear();
    queue_.flush(false);
    unused_before_ = queue_.unused();
    received_ = refused_ = found_ = late_ = 0;
  }
  void stop() { queue_.flush(true); }

  // Errors: receive(), read().
  Status receive_counted(GstBuffer* buffer) {
    ++received_;
    Status status = receive(buffer);
    if (!status) ++refused_;
    return status;
  }

  // Streaming thread of the pictures: gets the results for a running time (sync::kNoTime: none), or
  // null. False: the stream is flushing.
  struct Limits {
    uint64_t max_age = 0, max_wait = 0;  // nanoseconds
  };
  bool take(int64_t time, const Limits& limits, Results* out) {
    if (sync_ == ResultsSync::Newest) {
      *out = newest_.at(time, limits.max_age);
      return true;
    }
    out->reset();
    if (time == sync::kNoTime) return true;
    using Outcome = sync::TimedOutcome;
    const std::chrono::nanoseconds wait(static_cast<int64_t>(limits.max_wait));
    const Outcome outcome = queue_.take(time, wait, out);
    found_ += outcome == Outcome::Found;
    late_ += outcome == Outcome::Late;
    return outcome != Outcome::Flushed;
  }
  // Pictures whose results did not come in time.
  uint64_t late() const noexcept { return late_; }
  void flush_pictures(bool on) {
    queue_.flush(on);
    if (!on) newest_.clear();
  }

  // `used` names the results that were paired with a picture at least once.
  void add_stats(GstStructure* stats, const char* used) const {
    const auto newest = newest_.counts();
    const auto add = [stats](const char* name, uint64_t value) {
      gst_structure_set(stats, name, G_TYPE_UINT64, value, nullptr);
    };
    add("results-received", received_);
    add(used, newest.used + found_);
    add("results-replaced", newest.replaced);
    add("results-flushed", newest.cleared);
    add("results-unused", queue_.unused() - unused_before_);
    add("results-refused", refused_);
    add("results-held", newest.waiting + queue_.waiting());
    add("results-late", late_);
  }

 protected:
  // The results of one frame; `tensors` may be empty.
  virtual Result<Results> read(GstBuffer* buffer, const std::vector<TensorPlace>& tensors) = 0;

 private:
  Status push(GstBuffer* buffer, const std::vector<TensorPlace>& tensors, int64_t time) override {
    auto results = read(buffer, tensors);
    if (!results) return results.error();
    if (sync_ == ResultsSync::Newest)
      newest_.push(time, *std::move(results));
    else
      queue_.push(time, *std::move(results));
    return ok();
  }
  void advance(int64_t time) override { queue_.advance(time); }
  void end() override { queue_.end(); }
  // Pictures continue without results meanwhile.
  void flush(bool on) override {
    if (on) {
      queue_.end();
      return;
    }
    newest_.clear();
    queue_.clear();
  }

  std::atomic<ResultsSync> sync_{ResultsSync::Newest};
  sync::Newest<Item> newest_;
  sync::TimedQueue<Results> queue_;  // used by ResultsSync::SameTime
  std::atomic<uint64_t> received_{0}, refused_{0}, found_{0}, late_{0};
  std::atomic<uint64_t> unused_before_{0};  // of previous streams
};

}  // namespace gst
}  // namespace weir
