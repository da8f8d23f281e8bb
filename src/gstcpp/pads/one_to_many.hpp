// OneToMany<Impl>: an element with one sink pad and source pads that are made on first use.
//
// In addition to what Element requires, Impl has
//   static constexpr const char* kSourceTemplate          the name of the source pads' template
//   Status prepare(const Settings&)                       READY->PAUSED: reads the properties
//   Status configure(const FrameSpec&)                    caps arrived
//   Result<Routed> route(Ref<GstBuffer>)                  one frame; it pushes to `outputs_`
// and may have
//   void before_eos()                                         EOS arrived and is forwarded next
//   Status follow(const Settings&)                        between two frames, after a change of
//                                                         properties; an error is posted as a
//                                                         warning, and they read back as before
//   static constexpr bool kKeepsPads = true               pads and links stay in READY
//   static constexpr bool kPassesTensors = true           frames are pushed as they are: the event
//                                                         of the model that made them is too, and
//                                                         the format stays
// A frame with an error counts as dropped, and the error is posted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/pads/sometimes_pads.hpp"

namespace weir::gst {

// The result of a frame: pushed to some pad, or dropped as the user configured.
struct Routed {
  GstFlowReturn flow = GST_FLOW_OK;
  bool dropped = false;
};

template <class Impl>
class OneToMany : public Element<Impl, PlainElement> {
  using Base = Element<Impl, PlainElement>;

 public:
  void constructed() {
    GstElement* element = this->element();
    sink_ = gst_pad_new_from_template(
        gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element), "sink"), "sink");
    gst_pad_set_chain_function(sink_, (Base::template chain<&Impl::on_buffer>));
    gst_pad_set_event_function(sink_, (Base::template pad_event<&Impl::on_event>));
    gst_pad_set_query_function(sink_, query_with_static_filter);
    outputs_.attach(element, sink_, Impl::kSourceTemplate, passes_tensors());
    gst_element_add_pad(element, sink_);
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      ledger_.reset();
      spec_.reset();
      failed_ = false;
      outputs_.start();
      if (const Status status = impl()->prepare(this->take_settings(&impl()->followed_)); !status) {
        post_error(this->element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    const auto result = Base::parent_class()->change_state(this->element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) {
      if constexpr (requires { Impl::kKeepsPads; })
        outputs_.keep();
      else
        outputs_.clear();
    }
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* raw) {
    auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    if (!spec_) {
      ledger_.dropped(DropReason::Error);
      fail(buffer_before_caps("put a tensor_converter upstream"));
      return GST_FLOW_NOT_NEGOTIATED;
    }
    if constexpr (requires { impl()->follow(this->settings()); })
      this->follow_settings(&impl()->followed_,
                            [this](const auto& wanted) { return impl()->follow(wanted); });
    const Result<Routed> routed = impl()->route(std::move(buffer));
    if (!routed) {
      ledger_.dropped(DropReason::Error);
      fail(routed.error());
      return routed.error().code == Code::SPEC_MISMATCH ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
    }
    if (routed->dropped)
      ledger_.dropped(DropReason::Policy);
    else
      ledger_.consumed();
    return routed->flow;
  }

  gboolean on_event(GstPad*, GstEvent* raw) {
    auto event = Ref<GstEvent>::adopt(raw);
    if (!passes_tensors() && is_model_event(raw)) return TRUE;
    switch (GST_EVENT_TYPE(raw)) {
      case GST_EVENT_CAPS: {
        GstCaps* caps = nullptr;
        gst_event_parse_caps(raw, &caps);
        const Status status = set_caps(caps);
        if (!status) fail(status.error());
        return status.has_value();
      }
      case GST_EVENT_EOS:
        if constexpr (requires { impl()->before_eos(); })
          if (spec_) impl()->before_eos();
        // An earlier error already explains why nothing was pushed.
        if (!outputs_.any() && !failed_) fail(no_output());
        break;
      default:
        break;
    }
    // The sink pad keeps sticky events for later pads; a flush needs no pads.
    const auto type = GST_EVENT_TYPE(raw);
    const bool sticky = (gst_event_type_get_flags(type) & GST_EVENT_TYPE_STICKY) != 0;
    const bool done = (sticky && type != GST_EVENT_EOS) || type == GST_EVENT_FLUSH_START ||
                      type == GST_EVENT_FLUSH_STOP;
    return outputs_.send(std::move(event)) || done;
  }

  void add_stats(GstStructure* stats) const { outputs_.add_stats(stats); }

  Ledger ledger_;

 protected:
  GstFlowReturn push(SometimesPads::Output* output, Ref<GstBuffer> buffer) {
    ledger_.pushed();
    return outputs_.push(output, std::move(buffer));
  }
  const FrameSpec& spec() const noexcept { return *spec_; }  // from configure() on

  SometimesPads outputs_;

 private:
  static constexpr bool passes_tensors() {
    if constexpr (requires { Impl::kPassesTensors; }) return Impl::kPassesTensors;
    return false;
  }
  Impl* impl() { return static_cast<Impl*>(this); }

  void fail(const Error& error) {
    failed_ = true;
    post_error(this->element(), error);
  }

  Error no_output() const {
    const uint64_t frames = ledger_.snapshot().received;
    const bool none = frames == 0;
    return {.code = Code::NOT_NEGOTIATED,
            .what = "the stream ended without any output",
            .offered = none ? "no frame" : "frames without output: " + std::to_string(frames),
            .needed = none ? "at least one frame" : "at least one frame with output",
            .fix = none ? "check the upstream element: it sends no buffers"
                        : "check the properties that select the output, and earlier errors"};
  }

  Status set_caps(GstCaps* caps) {
    spec_.reset();
    auto spec = fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    spec->roles = roles_from_caps(caps);
    if (auto status = impl()->configure(*spec); !status) return status;
    spec_ = *std::move(spec);
    outputs_.unsettle();
    return ok();
  }

  GstPad* sink_ = nullptr;         // owned by the element
  std::optional<FrameSpec> spec_;  // streaming thread
  bool failed_ = false;            // likewise: since the start
};

}  // namespace weir::gst
