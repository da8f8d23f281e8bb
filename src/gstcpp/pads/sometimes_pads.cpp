// Makes source pads and sends their events before and between buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/sometimes_pads.hpp"

#include <string>

#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/model_event.hpp"

namespace weir::gst {
namespace {

Error mismatch(GstPad* pad, const PeerCaps& peer, const FrameSpec& spec, const GstCaps* caps) {
  const UniqueText name{gst_object_get_name(GST_OBJECT_CAST(pad))};
  return downstream_mismatch(
      name.get(), peer.caps.get(),
      caps ? to_string(caps) : spec.to_string() + ", " + std::string(to_string(spec.format)),
      "insert a tensor_transform or tensor_converter, or change the capsfilter");
}

}  // namespace

void SometimesPads::attach(GstElement* element, GstPad* sink, const char* source_template,
                           bool passes_tensors) {
  passes_tensors_ = passes_tensors;
  element_ = element;
  sink_ = sink;
  template_ = gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element), source_template);
}

void SometimesPads::start() {
  expected_ = 0;
  reported_all_ = false;
}

void SometimesPads::expect(size_t pads) {
  expected_ = pads;
}

void SometimesPads::clear() {
  std::vector<std::unique_ptr<Output>> outputs;
  {
    std::lock_guard lock(mutex_);
    outputs.swap(outputs_);
  }
  made_ = 0;
  for (const auto& output : outputs) {
    if (!output) continue;
    gst_flow_combiner_remove_pad(combiner_.get(), output->pad.get());
    gst_pad_set_active(output->pad.get(), FALSE);
    gst_element_remove_pad(element_, output->pad.get());
  }
  gst_flow_combiner_reset(combiner_.get());
}

void SometimesPads::keep() {
  std::lock_guard lock(mutex_);
  for (const auto& output : outputs_) {
    if (!output) continue;
    output->started = output->open = output->settled = output->begun_again = false;
    output->pushed = 0;
  }
  made_ = 0;
  gst_flow_combiner_reset(combiner_.get());
}

SometimesPads::Output& SometimesPads::output(size_t index) {
  if (index >= outputs_.size() || !outputs_[index])
    make(index);
  else if (!outputs_[index]->started)
    begin(outputs_[index].get());
  return *outputs_[index];
}

void SometimesPads::make(size_t index) {
  const std::string name = "src_" + std::to_string(index);
  auto output = std::make_unique<Output>();
  GstPad* pad = gst_pad_new_from_template(template_, name.c_str());
  output->pad = Ref<GstPad>::adopt(GST_PAD_CAST(gst_object_ref_sink(pad)));
  {
    std::lock_guard lock(mutex_);
    if (index >= outputs_.size()) outputs_.resize(index + 1);
    outputs_[index] = std::move(output);
  }
  gst_flow_combiner_add_pad(combiner_.get(), pad);
  begin(outputs_[index].get());
}

// Adds a new pad to the element.
void SometimesPads::begin(Output* output) {
  GstPad* pad = output->pad.get();
  output->started = true;
  gst_pad_set_active(pad, TRUE);
  const auto upstream =
      Ref<GstEvent>::adopt(gst_pad_get_sticky_event(sink_, GST_EVENT_STREAM_START, 0));
  gst_pad_push_event(pad, stream_start(pad, upstream.get()).release());
  if (!GST_OBJECT_PARENT(pad)) gst_element_add_pad(element_, pad);  // delayed links join here
  ++made_;
  if (made_ == expected_ && !std::exchange(reported_all_, true)) gst_element_no_more_pads(element_);
}

Ref<GstEvent> SometimesPads::stream_start(GstPad* pad, GstEvent* upstream) const {
  const UniqueText name{gst_object_get_name(GST_OBJECT_CAST(pad))};
  if (!upstream) {
    const UniqueText id{gst_pad_create_stream_id(pad, element_, name.get())};
    return Ref<GstEvent>::adopt(gst_event_new_stream_start(id.get()));
  }
  const char* whole = nullptr;
  gst_event_parse_stream_start(upstream, &whole);
  const std::string id = std::string(whole) + "/" + name.get();
  GstEvent* event = gst_event_new_stream_start(id.c_str());
  GstStreamFlags flags = GST_STREAM_FLAG_NONE;
  gst_event_parse_stream_flags(upstream, &flags);
  gst_event_set_stream_flags(event, flags);
  gst_event_set_seqnum(event, gst_event_get_seqnum(upstream));
  guint group = 0;
  if (gst_event_parse_group_id(upstream, &group)) gst_event_set_group_id(event, group);
  return Ref<GstEvent>::adopt(event);
}

void SometimesPads::send_sticky_events(GstPad* pad) const {
  struct Target {
    GstPad* pad;
    bool passes_tensors;
  } target{pad, passes_tensors_};
  gst_pad_sticky_events_foreach(
      sink_,
      [](GstPad*, GstEvent** event, gpointer user) -> gboolean {
        const auto& to = *static_cast<Target*>(user);
        const auto type = GST_EVENT_TYPE(*event);
        if (type != GST_EVENT_STREAM_START && type != GST_EVENT_CAPS && type != GST_EVENT_EOS &&
            (to.passes_tensors || !is_model_event(*event)))
          gst_pad_push_event(to.pad, gst_event_ref(*event));
        return TRUE;
      },
      &target);
}

void SometimesPads::unsettle() noexcept {
  for (const auto& output : outputs_)
    if (output) output->settled = false;
}

Result<bool> SometimesPads::settle(Output* output, const FrameSpec& spec) {
  GstPad* pad = output->pad.get();
  const bool relinked = gst_pad_check_reconfigure(pad);
  if (output->settled && !relinked) return false;
  const PeerCaps peer(pad);
  const auto caps = choose_caps(pad, peer, spec, !passes_tensors_);
  if (!caps) return mismatch(pad, peer, spec, nullptr);
  const auto before = Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad));
  const bool same =
      output->open && !output->begun_again && before && gst_caps_is_equal(before.get(), caps.get());
  if (!same) {
    if (gst_pad_is_linked(pad) && !gst_pad_peer_query_accept_caps(pad, caps.get()))
      return mismatch(pad, peer, spec, caps.get());
    log_output_caps(pad, caps.get());
    gst_pad_push_event(pad, gst_event_new_caps(caps.get()));
    const auto chosen = spec_from_caps(caps.get());
    if (!chosen) return chosen.error();
    output->format = chosen->format;
    output->begun_again = false;
  }
  if (!output->open) send_sticky_events(pad);
  output->open = output->settled = true;
  return !same;
}

Status SometimesPads::takes(size_t index, const FrameSpec& spec) const {
  if (index >= outputs_.size() || !outputs_[index] || !is_linked(*outputs_[index])) return ok();
  GstPad* pad = outputs_[index]->pad.get();
  const PeerCaps peer(pad);
  const auto caps = choose_caps(pad, peer, spec, !passes_tensors_);
  if (downstream_accepts(pad, peer, caps.get())) return ok();
  return mismatch(pad, peer, spec, caps.get());
}

GstFlowReturn SometimesPads::combined(GstFlowReturn flow) const noexcept {
  return flow == GST_FLOW_NOT_LINKED && made_ < expected_ ? GST_FLOW_OK : flow;
}

GstFlowReturn SometimesPads::push(Output* output, Ref<GstBuffer> buffer) {
  ++output->pushed;
  const GstFlowReturn flow = gst_pad_push(output->pad.get(), buffer.release());
  return combined(gst_flow_combiner_update_pad_flow(combiner_.get(), output->pad.get(), flow));
}

GstFlowReturn SometimesPads::pass_over(Output* output) noexcept {
  return combined(
      gst_flow_combiner_update_pad_flow(combiner_.get(), output->pad.get(), GST_FLOW_NOT_LINKED));
}

bool SometimesPads::send(const Ref<GstEvent>& event) {
  std::vector<Ref<GstPad>> pads;
  const auto type = GST_EVENT_TYPE(event.get());
  // A pad without caps gets only the start, the end and flushes of its stream.
  const bool to_all = type == GST_EVENT_STREAM_START || type == GST_EVENT_EOS ||
                      type == GST_EVENT_FLUSH_START || type == GST_EVENT_FLUSH_STOP;
  {
    std::lock_guard lock(mutex_);
    for (const auto& output : outputs_)
      if (output && (to_all || output->open)) {
        pads.push_back(output->pad);
        if (type == GST_EVENT_STREAM_START) output->begun_again = true;
      }
  }
  if (type == GST_EVENT_FLUSH_STOP) gst_flow_combiner_reset(combiner_.get());
  bool taken = false;
  for (const auto& pad : pads) {
    auto own = type == GST_EVENT_STREAM_START ? stream_start(pad.get(), event.get()) : event;
    taken |= gst_pad_push_event(pad.get(), own.release()) != FALSE;
  }
  return taken;
}

void SometimesPads::add_stats(GstStructure* stats) const {
  std::lock_guard lock(mutex_);
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const std::string name = "pushed-src_" + std::to_string(i);
    if (outputs_[i])
      gst_structure_set(stats, name.c_str(), G_TYPE_UINT64, outputs_[i]->pushed.load(), nullptr);
  }
}

}  // namespace weir::gst
