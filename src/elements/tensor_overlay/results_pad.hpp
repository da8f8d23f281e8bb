// ResultsPad: the sink pad for result tensors that are drawn on pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <memory>

#include "core/draw/detections.hpp"
#include "core/sync/newest.hpp"
#include "core/sync/timed_queue.hpp"
#include "gstcpp/pads/timed_tensors.hpp"

namespace weir {

enum class ResultsSync : int32_t { Newest, SameTime };
enum class Coordinates : int32_t { Picture, Tensor };

class ResultsPad final : public gst::TimedTensors {
 public:
  using Results = std::shared_ptr<const draw::Detections>;

  // Call before a stream starts.
  void start(ResultsSync sync, Coordinates coordinates);
  void stop() { queue_.flush(true); }
  // Errors: TimedTensors::receive(), check_detections(), read_detections(); SPEC_MISMATCH for
  // frames of several tensors, and for frames without a required source map.
  Status receive_counted(GstBuffer* buffer);

  // Streaming thread of the pictures: gets the results for a running time (sync::kNoTime: none), or
  // null. False: the stream is flushing.
  struct Limits {
    uint64_t max_age = 0, max_wait = 0;  // nanoseconds
  };
  bool take(int64_t time, const Limits& limits, Results* out);
  void flush_pictures(bool on);

  void add_stats(GstStructure* stats) const;

 private:
  Status accept(const FrameSpec& spec) override;
  Status push(GstBuffer* buffer, const std::vector<gst::TensorView>& tensors,
              int64_t time) override;
  void advance(int64_t time) override { queue_.advance(time); }
  void end() override { queue_.end(); }
  void flush(bool on) override;
  Result<Results> read(GstBuffer* buffer, const gst::TensorView& tensor);
  void count(const draw::LeftOut& left_out);

  std::atomic<ResultsSync> sync_{ResultsSync::Newest};
  std::atomic<Coordinates> coordinates_{Coordinates::Picture};
  sync::Newest<draw::Detections> newest_;
  sync::TimedQueue<Results> queue_;  // used by ResultsSync::SameTime
  std::atomic<uint64_t> received_{0}, refused_{0}, found_{0}, late_{0};
  std::atomic<uint64_t> unused_before_{0};  // of previous streams
  std::atomic<uint64_t> background_{0}, not_finite_{0}, without_area_{0}, beyond_limit_{0};
  std::atomic<uint64_t> points_not_finite_{0};
};

}  // namespace weir
