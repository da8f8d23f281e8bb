// tensor_reposink: the end of a loop; passes each frame to the tensor_reposrc of its slot.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>

#include "elements/tensor_reposink/repository.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

// One ledger per run: frames of an earlier run may still be in a slot.
class RunLedger {
 public:
  LedgerSnapshot snapshot() const { return get()->snapshot(); }
  std::shared_ptr<Ledger> get() const {
    std::lock_guard lock(mutex_);
    return ledger_;
  }
  void renew() {
    auto fresh = std::make_shared<Ledger>();
    std::lock_guard lock(mutex_);
    ledger_.swap(fresh);
  }

 private:
  mutable std::mutex mutex_;  // guards ledger_
  std::shared_ptr<Ledger> ledger_ = std::make_shared<Ledger>();
};

class TensorReposink : public gst::Element<TensorReposink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorReposink", "tensor_reposink", "TensorRepoSink", "Sink/Tensor/Repository",
      "Ends a loop: passes frames to the tensor_reposrc of the same slot"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "sink", GST_PAD_SINK, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR
                          "; other/tensors, "
                          "format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE
                          "; " WEIR_CAPS_TENSORS("flexible"))),
  };

  struct Settings {
    uint32_t signal_rate = 0;
    uint32_t slot_index = 0;
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"signal-rate", &Settings::signal_rate,
                    "Accepted for compatibility; has no effect", gst::Changeable::WhilePlaying, 0u,
                    500u},
      gst::Property{"slot-index", &Settings::slot_index,
                    "Number of the slot to which frames are passed", gst::Changeable::WhilePlaying},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
  };

  void constructed() {
    gst_base_sink_set_sync(self(), FALSE);
    gst_base_sink_set_async_enabled(self(), FALSE);
    gst_base_sink_set_qos_enabled(self(), TRUE);
    // Another reference to each frame would prevent the loop from working in place.
    gst_base_sink_set_last_sample_enabled(self(), FALSE);
  }

  void property_changed(const char* name) {
    if (std::string_view(name) == "slot-index") count_left(writer_.move(settings().slot_index));
  }

  GstStateChangeReturn change_state(GstStateChange transition) {
    if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
      ledger_.renew();
      writer_.attach(settings().slot_index);
    }
    // GstBaseSink takes the preroll lock, which a waiting render() holds: the interrupt releases
    // it.
    if (transition == GST_STATE_CHANGE_PAUSED_TO_PLAYING) writer_.interrupt();
    const auto result = GST_ELEMENT_CLASS(parent_class())->change_state(element(), transition);
    if (transition != GST_STATE_CHANGE_PAUSED_TO_READY) take_no_part_in_preroll();
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY || result == GST_STATE_CHANGE_FAILURE)
      count_left(writer_.detach());
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) caps_ = {};
    return result;
  }

  gboolean query(GstQuery* query) {
    return gst::with_static_filter(
        query, [&](GstQuery* described) { return parent_class()->query(self(), described); });
  }

  Status set_caps(GstCaps* caps) {
    auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    spec_ = *spec;
    caps_ = Ref<GstCaps>::share(caps);
    return ok();
  }

  GstFlowReturn render(GstBuffer* buffer) {
    const auto ledger = ledger_.get();
    ledger->received();
    if (const Status status = check(buffer); !status) {
      ledger->dropped(DropReason::Error);
      gst::post_error(element(), status.error());
      return caps_ ? GST_FLOW_ERROR : GST_FLOW_NOT_NEGOTIATED;
    }
    StoredFrame frame{Ref<GstBuffer>::share(buffer), caps_, ledger, labels_};
    for (;;) {
      const loop::Put put = writer_.put(frame);
      if (put == loop::Put::Stored) return GST_FLOW_OK;
      if (put == loop::Put::Unwanted) {
        ledger->dropped(DropReason::Eos);
        return GST_FLOW_OK;
      }
      // A pause also interrupts the wait; only a flush or the change to READY ends it.
      if (const auto flow = gst_base_sink_wait_preroll(self()); flow != GST_FLOW_OK) {
        ledger->dropped(DropReason::Flush);
        return flow;
      }
    }
  }

  gboolean unlock() {
    writer_.interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    writer_.resume();
    return TRUE;
  }

  gboolean event(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_EOS) writer_.end();
    if (type == GST_EVENT_STREAM_START) {
      writer_.begin();
      labels_ = nullptr;
    }
    if (auto labels = gst::parse_labels_event(event)) add_labels(*std::move(labels));
    const gboolean done = parent_class()->event(self(), event);
    if (type == GST_EVENT_FLUSH_STOP) {
      if (const auto lost = writer_.flush()) lost->ledger->dropped(DropReason::Flush);
      take_no_part_in_preroll();
    }
    return done;
  }

  Settings settings_;
  RunLedger ledger_;

 private:
  // GstBaseSink blocks the first frame in PAUSED. Other sinks of the loop may need the result of
  // this frame for their preroll, so it is stored in its slot immediately.
  void take_no_part_in_preroll() {
    // A wait in render() becomes the preroll wait, which releases the lock.
    writer_.interrupt();
    GST_BASE_SINK_PREROLL_LOCK(self());
    writer_.resume();
    self()->need_preroll = FALSE;
    GST_BASE_SINK_PREROLL_SIGNAL(self());
    GST_BASE_SINK_PREROLL_UNLOCK(self());
  }

  // Frames in the slot keep the labels that they were stored with. Labels that have gone round the
  // loop change nothing, or they would go round for ever.
  void add_labels(gst::LabelsOfSource labels) {
    if (labels_) {
      const auto known = labels_->find(labels.source);
      if (known != labels_->end() && known->second == labels) return;
    }
    auto all =
        labels_ ? std::make_shared<LabelsBySource>(*labels_) : std::make_shared<LabelsBySource>();
    std::string source = labels.source;
    all->insert_or_assign(std::move(source), std::move(labels));
    labels_ = std::move(all);
  }

  Status check(GstBuffer* buffer) {
    if (!caps_) return gst::buffer_before_caps("tensor_converter ! tensor_reposink");
    if (spec_.format == Format::Flexible) return layout_.locate(buffer, spec_);
    return gst::whole_frame(spec_, gst_buffer_get_size(buffer));
  }

  Repository::Writer writer_{repository(), {[this](uint32_t slot) {
                               gst::post_warning(element(), lone_end("tensor_reposrc", slot));
                             }}};
  // Streaming thread only.
  FrameSpec spec_;  // of the input
  gst::FrameLayout layout_;
  Ref<GstCaps> caps_;                             // of the frames; null without caps
  std::shared_ptr<const LabelsBySource> labels_;  // of the stream; null without labels
};

}  // namespace

bool register_tensor_reposink(GstPlugin* plugin) {
  return TensorReposink::register_in(plugin);
}

}  // namespace weir
