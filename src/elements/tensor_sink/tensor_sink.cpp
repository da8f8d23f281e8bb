// tensor_sink: emits a signal with each frame of tensors for the application.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorSink : public gst::Element<TensorSink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSink", "tensor_sink", "TensorSink",
                                          "Sink/Tensor",
                                          "Passes each frame of tensors to the application"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible, sparse }"))),
  };

  struct Settings {
    uint32_t signal_rate = 0;
    bool emit_signal = true;
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"signal-rate", &Settings::signal_rate,
                    "Maximum number of new-data signals per second; 0 = one for each frame",
                    gst::Changeable::WhilePlaying, 0u, 500u},
      gst::Property{"emit-signal", &Settings::emit_signal, "Emit new-data, stream-start and eos",
                    gst::Changeable::WhilePlaying},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
  };

  static void install_signals(GType type) {
    const auto add = [type](const char* name, guint count, GType argument) {
      return g_signal_new(name, type, G_SIGNAL_RUN_LAST, 0, nullptr, nullptr, nullptr, G_TYPE_NONE,
                          count, argument);
    };
    new_data_ = add("new-data", 1, GST_TYPE_BUFFER);
    stream_start_ = add("stream-start", 0, G_TYPE_NONE);
    eos_ = add("eos", 0, G_TYPE_NONE);
  }

  void constructed() {
    gst_base_sink_set_sync(self(), FALSE);
    gst_base_sink_set_qos_enabled(self(), TRUE);
    gst_base_sink_set_max_lateness(self(), -1);
  }

  // GstBaseSink calls start() once for READY; a stream starts at READY->PAUSED.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      ledger_.reset();
      last_signal_ = GST_CLOCK_TIME_NONE;
      not_signalled_ = 0;
    }
    return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
  }

  Status set_caps(GstCaps* caps) {
    const auto spec = gst::spec_from_caps(caps);
    return spec ? ok() : Status(spec.error());
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    if (wants_signal())
      g_signal_emit(self(), new_data_, 0, buffer);
    else
      ++not_signalled_;
    ledger_.consumed();
    return GST_FLOW_OK;
  }

  gboolean event(GstEvent* event) {
    const bool emit = settings().emit_signal;
    if (emit && GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START)
      g_signal_emit(self(), stream_start_, 0);
    if (emit && GST_EVENT_TYPE(event) == GST_EVENT_EOS) g_signal_emit(self(), eos_, 0);
    return parent_class()->event(self(), event);
  }

  gboolean query(GstQuery* query) {
    if (GST_QUERY_TYPE(query) != GST_QUERY_SEEKING)
      return gst::with_static_filter(
          query, [&](GstQuery* described) { return parent_class()->query(self(), described); });
    GstFormat format;
    gst_query_parse_seeking(query, &format, nullptr, nullptr, nullptr);
    gst_query_set_seeking(query, format, FALSE, 0, -1);
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "not-signalled", G_TYPE_UINT64, not_signalled_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  // Signals are at least 1000 / signal-rate milliseconds apart, by the clock.
  bool wants_signal() {
    const Settings s = settings();
    if (!s.emit_signal) return false;
    if (s.signal_rate == 0) return true;
    const auto clock = Ref<GstClock>::adopt(gst_element_get_clock(element()));
    if (!clock) return true;
    const GstClockTime now = gst_clock_get_time(clock.get());
    const GstClockTime interval = 1000 / s.signal_rate * GST_MSECOND;
    if (GST_CLOCK_TIME_IS_VALID(last_signal_) && now >= last_signal_ &&
        now - last_signal_ < interval)
      return false;
    last_signal_ = now;
    return true;
  }

  static inline guint new_data_ = 0, stream_start_ = 0, eos_ = 0;
  GstClockTime last_signal_ = GST_CLOCK_TIME_NONE;  // streaming thread only
  std::atomic<uint64_t> not_signalled_{0};
};

}  // namespace

bool register_tensor_sink(GstPlugin* plugin) {
  return TensorSink::register_in(plugin);
}

}  // namespace weir
