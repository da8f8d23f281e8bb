// tensor_rate: converts a stream to a fixed rate by dropping and repeating frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>
#include <optional>

#include "core/rate/frame_rate.hpp"
#include "core/sync/backwards_time.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/pads/latency.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorRate : public gst::CountedTransform<TensorRate> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorRate", "tensor_rate", "TensorRate",
                                          "Filter/Tensor",
                                          "Drops and repeats frames for a fixed frame rate"};
#define WEIR_RATE_CAPS                                                                   \
  WEIR_CAPS_TENSOR                                                                       \
  "; other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE \
  "; " WEIR_CAPS_TENSORS("flexible")
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_RATE_CAPS)),
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_RATE_CAPS)),
  };
  struct Settings {
    bool silent = true, throttle = true;
    uint64_t max_duplication_time = 60 * GST_SECOND;
    std::string framerate;
    std::string framerate_read;      // the last valid text
    std::optional<Fraction> wanted;  // its value
    Status problem = ok();           // posted at start, when there is a bus
  };
  uint64_t in() const {
    return in_;
  }
  uint64_t out() const {
    return out_;
  }
  uint64_t duplicate() const {
    return duplicate_;
  }
  uint64_t drop() const {
    return drop_;
  }
  static constexpr std::tuple kProperties{
      gst::ReadOnly{"in", &TensorRate::in, "Number of received frames"},
      gst::ReadOnly{"out", &TensorRate::out, "Number of pushed frames"},
      gst::ReadOnly{"duplicate", &TensorRate::duplicate, "Number of duplicated frames"},
      gst::ReadOnly{"drop", &TensorRate::drop, "Number of dropped frames"},
      gst::Property{"silent", &Settings::silent, "False = notify changes of drop and duplicate",
                    gst::Changeable::WhilePlaying},
      gst::Property{"throttle", &Settings::throttle,
                    "Send QoS events upstream so that only the needed frames are produced",
                    gst::Changeable::WhilePlaying},
      gst::Property{"framerate", &Settings::framerate,
                    "Output frame rate N/D; empty = every frame passes",
                    gst::Changeable::WhilePlaying},
      gst::Property{"max-duplication-time", &Settings::max_duplication_time,
                    "Longest time in nanoseconds between a frame and its duplicates; the rest of a "
                    "longer gap becomes a GAP event; 0 = fill every gap",
                    gst::Changeable::WhilePlaying},
  };

  void property_changed(const char* name) {
    if (std::strcmp(name, "framerate") != 0) return;
    Result<std::optional<Fraction>> rate = std::optional<Fraction>();
    // Together with the text, so that concurrent writers leave no mix.
    change_settings([&](Settings& s) {
      rate = parse_frame_rate(s.framerate);
      if (rate) {
        s.framerate_read = s.framerate;
        s.wanted = *rate;
      } else {
        s.framerate = s.framerate_read;
      }
      s.problem = rate ? ok() : Status(rate.error());
    });
    if (rate)
      gst_base_transform_reconfigure_src(self());
    else
      gst::post_warning(element(), rate.error());
  }

  Status start() {
    ledger_.reset();
    in_ = out_ = duplicate_ = drop_ = backwards_times_ = gap_events_ = gap_ticks_ = 0;
    if (const Status problem = settings().problem; !problem)
      gst::post_warning(element(), problem.error());
    return ok();
  }
  bool stop() {
    forget(DropReason::Flush);
    rate_.reset();
    latency_ = 0;
    return true;
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    auto out = Ref<GstCaps>::adopt(gst_caps_copy(caps));
    if (const auto wanted = settings().wanted) {
      for (guint i = 0; i < gst_caps_get_size(out.get()); ++i) {
        GstStructure* s = gst_caps_get_structure(out.get(), i);
        if (direction == GST_PAD_SINK)
          gst_structure_set(s, "framerate", GST_TYPE_FRACTION, wanted->numerator,
                            wanted->denominator, nullptr);
        else
          gst_structure_set(s, "framerate", GST_TYPE_FRACTION_RANGE, 0, 1, G_MAXINT, 1, nullptr);
      }
    }
    if (!filter) return out.release();
    return gst_caps_intersect_full(filter, out.get(), GST_CAPS_INTERSECT_FIRST);
  }

  Status set_caps(GstCaps* in, GstCaps* out) {
    const auto input = gst::fixed_spec_from_caps(in);
    if (!input) return input.error();
    const auto output = gst::fixed_spec_from_caps(out);
    if (!output) return output.error();
    end_of_held(DropReason::Flush);  // it is sent with the caps that it arrived with
    const bool wanted = settings().wanted.has_value();
    const bool same = input->rate == output->rate;
    rate_.reset();
    if (wanted && !same) rate_.emplace(output->rate);
    throttle_once_ = wanted && same ? std::optional(output->rate) : std::nullopt;
    gst_base_transform_set_passthrough(self(), !rate_);
    const bool known = input->rate.numerator > 0;
    latency_ = rate_ && known ? FrameRate(input->rate).interval() : 0;
    return ok();
  }

  // Nothing is written: copies share the frame's memory.
  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = in;
    return GST_FLOW_OK;
  }

  GstFlowReturn transform_ip(GstBuffer* in) {
    ++in_;
    if (!rate_) return pass(in);
    const auto time = get_time(in);
    if (!time || (rate_->held() && *time < *rate_->held())) {
      refuse(time);
      return GST_BASE_TRANSFORM_FLOW_DROPPED;
    }
    GstFlowReturn flow = GST_FLOW_OK;
    const uint64_t max_duplication = settings().max_duplication_time;
    while (flow == GST_FLOW_OK) {
      const auto tick = rate_->take_before(*time, max_duplication);
      if (!tick) break;
      if (tick->has_frame)
        flow = send(*tick);
      else
        send_gap(*tick);
    }
    if (held_ && copies_ == 0) throttle(rate_->interval(), *time);
    release(DropReason::Policy);
    rate_->hold(*time);
    held_ = Ref<GstBuffer>::share(in);
    return flow == GST_FLOW_OK ? GST_BASE_TRANSFORM_FLOW_DROPPED : flow;
  }

  GstFlowReturn pass(GstBuffer* in) {
    if (throttle_once_ && settings().throttle)
      throttle(FrameRate(*throttle_once_).interval(), GST_BUFFER_PTS(in));
    throttle_once_.reset();
    ++out_;
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  gboolean sink_event(GstEvent* event) {
    switch (GST_EVENT_TYPE(event)) {
      case GST_EVENT_EOS:
        end_of_held(DropReason::Eos);
        break;
      case GST_EVENT_SEGMENT:
        end_of_held(DropReason::Flush);
        break;
      case GST_EVENT_FLUSH_STOP:
        forget(DropReason::Flush);
        break;
      default:
        break;
    }
    return parent_class()->sink_event(self(), event);
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (direction == GST_PAD_SRC && GST_QUERY_TYPE(query) == GST_QUERY_LATENCY)
      return gst::handle_latency_query(GST_BASE_TRANSFORM_SINK_PAD(self()), query, latency_);
    return gst::with_static_filter(query, [&](GstQuery* described) {
      return parent_class()->query(self(), direction, described);
    });
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "backwards-times", G_TYPE_UINT64, backwards_times_.load(),
                      "gap-events", G_TYPE_UINT64, gap_events_.load(), "gap-ticks", G_TYPE_UINT64,
                      gap_ticks_.load(), nullptr);
  }

  Settings settings_;

 private:
  // The numbers of other segments are no times.
  bool has_time_segment() const {
    return self()->segment.format == GST_FORMAT_TIME;
  }
  uint64_t segment_base() const {
    return has_time_segment() ? self()->segment.base : 0;
  }

  // Across all segments so far. A frame without a timestamp starts at the end of the previous one.
  std::optional<uint64_t> get_time(GstBuffer* buffer) const {
    if (GST_BUFFER_PTS_IS_VALID(buffer)) return sum(GST_BUFFER_PTS(buffer), segment_base());
    return end_of_held_frame();
  }
  std::optional<uint64_t> end_of_held_frame() const {
    if (!held_ || !GST_BUFFER_DURATION_IS_VALID(held_.get())) return std::nullopt;
    return sum(*rate_->held(), GST_BUFFER_DURATION(held_.get()));
  }
  // nullopt beyond the range of GstClockTime.
  static std::optional<uint64_t> sum(GstClockTime a, GstClockTime b) {
    if (a >= GST_CLOCK_TIME_NONE - b) return std::nullopt;
    return a + b;
  }

  void refuse(std::optional<uint64_t> time) {
    count_drop();
    ledger_.dropped(DropReason::Time);
    if (time && backwards_times_++ == 0)
      gst::post_warning(element(), backwards_time(*time, *rate_->held(), OnBackwardsTime::Drop));
  }

  GstFlowReturn send(const Tick& tick) {
    auto out = Ref<GstBuffer>::adopt(gst_buffer_copy(held_.get()));
    GstBuffer* b = out.get();
    GST_BUFFER_PTS(b) = tick.time - segment_base();
    GST_BUFFER_DTS(b) = GST_CLOCK_TIME_NONE;
    GST_BUFFER_DURATION(b) = tick.duration;
    GST_BUFFER_OFFSET(b) = tick.number;
    GST_BUFFER_OFFSET_END(b) = tick.number + 1;
    GST_BUFFER_FLAG_UNSET(b, GST_BUFFER_FLAG_DISCONT);
    if (tick.number == 0) GST_BUFFER_FLAG_SET(b, GST_BUFFER_FLAG_DISCONT);
    if (copies_++ > 0) {
      GST_BUFFER_FLAG_SET(b, GST_BUFFER_FLAG_GAP);
      ++duplicate_;
      if (!settings().silent) g_object_notify(G_OBJECT(self()), "duplicate");
    }
    ++out_;
    ledger_.pushed();
    return gst_pad_push(GST_BASE_TRANSFORM_SRC_PAD(self()), out.release());
  }

  void send_gap(const Tick& ticks) {
    ++gap_events_;
    gap_ticks_ += ticks.count;
    GST_CAT_INFO_OBJECT(category(), self(), "GAP event instead of %" G_GUINT64_FORMAT " frames",
                        ticks.count);
    gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self()),
                       gst_event_new_gap(ticks.time - segment_base(), ticks.duration));
  }

  // Releases the held frame: all its ticks were sent.
  void release(DropReason reason) {
    if (!held_) return;
    if (copies_ > 0) {
      ledger_.consumed();
    } else {
      ledger_.dropped(reason);
      count_drop();
    }
    held_ = {};
    copies_ = 0;
  }

  // Sends the last tick, or those until the segment stops, and resets the time.
  void end_of_held(DropReason reason) {
    constexpr int kMaxCopies = 25;
    if (!rate_ || !held_) return;
    const uint64_t stop = self()->segment.stop;
    auto end = end_of_held_frame();
    int max = 1;
    if (has_time_segment() && GST_CLOCK_TIME_IS_VALID(stop) && reason == DropReason::Eos) {
      end = sum(stop, segment_base());
      max = kMaxCopies;
    }
    for (int i = 0; i < max; ++i) {
      const auto tick = rate_->take_at_end(end);
      if (!tick || send(*tick) != GST_FLOW_OK) break;
    }
    forget(reason);
  }
  void forget(DropReason reason) {
    release(reason);
    if (rate_) rate_->reset();
  }

  void count_drop() {
    ++drop_;
    if (!settings().silent) g_object_notify(G_OBJECT(self()), "drop");
  }

  void throttle(uint64_t interval, GstClockTime time) {
    if (!settings().throttle) return;
    const auto wait = static_cast<GstClockTimeDiff>(static_cast<double>(interval) * 0.999);
    gst_pad_push_event(GST_BASE_TRANSFORM_SINK_PAD(self()),
                       gst_event_new_qos(GST_QOS_TYPE_THROTTLE, 0.9, wait, time));
  }

  // Streaming thread only:
  std::optional<FrameRate> rate_;  // nullopt: every frame passes
  // Both rates are equal: sent upstream with the first frame.
  std::optional<Fraction> throttle_once_;
  Ref<GstBuffer> held_;
  uint64_t copies_ = 0;  // copies sent of the held frame
  // Any thread:
  std::atomic<GstClockTime> latency_{0};
  std::atomic<uint64_t> in_{0}, out_{0}, duplicate_{0}, drop_{0}, backwards_times_{0};
  std::atomic<uint64_t> gap_events_{0}, gap_ticks_{0};
};

}  // namespace

bool register_tensor_rate(GstPlugin* plugin) {
  return TensorRate::register_in(plugin);
}

}  // namespace weir
