// SinkCounter: counts what arrives at the sinks of a pipeline: frames of video and tensors, and
// buffers of other streams. A file that a muxer writes has buffers; its frames of video are
// counted where the muxer takes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::app {

struct SinkStatistics {
  std::string name;  // of the sink or the muxer
  uint64_t count = 0;
  bool is_frames = false;  // of video or tensors; else buffers
};

// Thread-safe.
class SinkCounter {
 public:
  // Counts at the sinks that `pipeline` has and at those that are added later.
  explicit SinkCounter(GstElement* pipeline);
  // The pipeline must be in state NULL: probes refer to this object.
  ~SinkCounter();
  SinkCounter(const SinkCounter&) = delete;
  SinkCounter& operator=(const SinkCounter&) = delete;

  std::vector<SinkStatistics> statistics() const;
  // Over all sinks: the frames if any has frames, else the buffers.
  SinkStatistics total() const;
  // Counts the frames of the sink with the most, by the same rule.
  uint64_t busiest() const;
  // Monotonic time in microseconds of the first buffer at any sink; 0 = none yet.
  gint64 first() const noexcept { return first_; }

 private:
  enum class Kind { Unknown, Frames, Buffers };
  struct Count {
    std::string name;
    bool is_muxer = false;
    std::atomic<gint64>* first = nullptr;
    std::atomic<Kind> kind = Kind::Unknown;
    std::atomic<uint64_t> count = 0;
  };
  void watch(GstElement* element);
  void watch(GstElement* element, GstPad* pad, bool is_muxer);
  static GstPadProbeReturn on_data(GstPad* pad, GstPadProbeInfo* info, gpointer count);
  static Kind find_kind(GstPad* pad);

  gst::Ref<GstElement> pipeline_;
  std::atomic<gint64> first_ = 0;
  mutable std::mutex mutex_;                    // guards counts_
  std::vector<std::unique_ptr<Count>> counts_;  // exist as long as probes may run
};

}  // namespace weir::app
