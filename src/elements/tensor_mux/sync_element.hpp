// SyncElement<Impl>: an element of request pads "sink_%u" and one source pad, with a sync policy.
//
// Impl has kInfo, kPads (sink first), a Settings derived from SyncSettings, kFallback (sync::Mode),
// ledger_, and is a gst::Combiner. Its optional Status prepare(const Settings&) is called at start
// and when a property changes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mutex>
#include <optional>

#include "elements/tensor_mux/sync_settings.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/pads/collector_pads.hpp"

namespace weir {

template <class Impl>
class SyncElement : public gst::Element<Impl, gst::PlainElement>, public gst::Combiner {
 public:
  void constructed() {
    GstElement* element = this->element();
    GstPad* source = gst_pad_new_from_static_template(&Impl::kPads[1], "src");
    gst_element_add_pad(element, source);
    pads_.emplace(element, source, &impl().ledger_, this);
  }

  GstPad* request_new_pad(GstPadTemplate* pad_template, const gchar* name, const GstCaps*) {
    return pads_->request(pad_template, name);
  }
  void release_pad(GstPad* pad) { pads_->release(pad); }

  GstStateChangeReturn change_state(GstStateChange transition) {
    if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
      impl().ledger_.reset();
      Status status = configure_pads();
      if (status) status = pads_->start();
      if (!status) {
        gst::post_error(this->element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) pads_->stop();
    const auto result = this->parent_class()->change_state(this->element(), transition);
    if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) pads_->forget_streams();
    return result;
  }

  void property_changed(const char*) {
    if (GST_STATE(this->element()) <= GST_STATE_READY) return;
    if (const Status status = configure_pads(); !status)
      gst::post_warning(this->element(), status.error());
    gst_pad_mark_reconfigure(pads_->source());  // properties affect the output caps
    gst_element_post_message(this->element(),
                             gst_message_new_latency(GST_OBJECT_CAST(this->element())));
  }

  void add_stats(GstStructure* stats) const { pads_->add_stats(stats); }

 private:
  Impl& impl() { return static_cast<Impl&>(*this); }

  Status configure_pads() {
    const auto choice = configure_by_settings();
    if (!choice) return choice.error();
    if (!choice->mode_status) gst::post_warning(this->element(), choice->mode_status.error());
    return ok();
  }
  Result<SyncChoice> configure_by_settings() {
    std::lock_guard lock(configure_mutex_);
    const auto settings = this->settings();
    if constexpr (requires { impl().prepare(settings); })
      if (auto status = impl().prepare(settings); !status) return status.error();
    auto choice = sync_choice(settings, Impl::kFallback);
    if (choice)
      pads_->configure(choice->options, settings.on_backwards_time, settings.max_wait,
                       settings.max_bytes);
    return choice;
  }

  std::mutex configure_mutex_;  // orders concurrent settings; taken before the settings lock
  std::optional<gst::CollectorPads> pads_;
};

}  // namespace weir
