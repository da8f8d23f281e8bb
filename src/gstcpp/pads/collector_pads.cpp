// CollectorPads: pads, negotiation, and one output buffer from the frames of all pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/collector_pads.hpp"

#include <algorithm>
#include <string>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/element.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/pads/streaming_threads.hpp"
#include "weir/join.hpp"

namespace weir::gst {
namespace {

static_assert(sync::kNotLinked == GST_FLOW_NOT_LINKED && sync::kFlushing == GST_FLOW_FLUSHING &&
              sync::kEnded == GST_FLOW_EOS && sync::kRefused == GST_FLOW_ERROR &&
              sync::kOk == GST_FLOW_OK);

sync::Stamp to_stamp(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? sync::Stamp(time) : sync::Stamp();
}

std::string get_name(GstPad* pad) {
  const UniqueText text{gst_pad_get_name(pad)};
  return text.get();
}

}  // namespace

CollectorPads::CollectorPads(GstElement* element, GstPad* source, Ledger* ledger,
                             Combiner* combiner)
    : element_(element),
      source_(source),
      ledger_(ledger),
      combiner_(combiner),
      collector_(ledger, this) {
  gst_pad_set_element_private(source, this);
  gst_pad_set_event_function(source, on_source_event);
  gst_pad_set_query_function(source, on_source_query);
  gst_pad_use_fixed_caps(source);
  mark_waits_for_all(element);
}

CollectorPads::~CollectorPads() = default;

// The GstPad owns the state of the pad: a thread that sends an event to the pad during its release
// can still use it.
void CollectorPads::attach(GstPad* pad) {
  static const GQuark quark = g_quark_from_static_string("weir-collector-pad");
  auto made = std::make_shared<Pad>();
  made->owner = this;
  made->pad = pad;
  made->queue = collector_.add();
  collector_.set_active(made->queue, false);
  gst_segment_init(&made->segment, GST_FORMAT_UNDEFINED);
  g_object_set_qdata_full(G_OBJECT(pad), quark, new std::shared_ptr<Pad>(made),
                          [](gpointer data) { delete static_cast<std::shared_ptr<Pad>*>(data); });
  gst_pad_set_element_private(pad, made.get());
  gst_pad_set_chain_function(pad, on_chain);
  gst_pad_set_event_function(pad, on_sink_event);
  gst_pad_set_query_function(pad, on_sink_query);
  gst_pad_set_activatemode_function(pad, on_activate);
  std::lock_guard lock(pads_mutex_);
  pads_.push_back(std::move(made));
}

GstPad* CollectorPads::request(GstPadTemplate* pad_template, const char* wanted) {
  const auto taken = [this](const std::string& name) {
    return static_cast<bool>(
        Ref<GstPad>::adopt(gst_element_get_static_pad(element_, name.c_str())));
  };
  std::string name = wanted && !std::string(wanted).ends_with("%u") ? wanted : "";
  if (!name.empty() && taken(name)) return nullptr;
  {
    std::lock_guard lock(pads_mutex_);
    while (name.empty() || taken(name)) name = "sink_" + std::to_string(counter_++);
  }
  GstPad* pad = gst_pad_new_from_template(pad_template, name.c_str());
  attach(pad);
  gst_pad_set_active(pad, TRUE);
  gst_element_add_pad(element_, pad);
  return pad;
}

void CollectorPads::release(GstPad* pad) {
  auto* data = static_cast<Pad*>(gst_pad_get_element_private(pad));
  if (!data) return;
  const auto held = Ref<GstPad>::share(pad);
  if (collector_.remove(data->queue))
    send_flush(Ref<GstEvent>::adopt(gst_event_new_flush_stop(TRUE)));
  gst_pad_set_active(pad, FALSE);
  gst_element_remove_pad(element_, pad);
  gst_pad_set_element_private(pad, nullptr);
  {
    std::lock_guard lock(pads_mutex_);
    std::erase_if(pads_, [data](const auto& p) { return p.get() == data; });
  }
  proceed_later();
}

// Downstream may block a push; the thread that releases a pad must not wait for it.
void CollectorPads::proceed_later() {
  if (GST_STATE(element_) < GST_STATE_PAUSED) return;
  const auto proceed = +[](GstElement* element, gpointer self) {
    guarded<void>(element, [&] { static_cast<CollectorPads*>(self)->collector_.proceed(); });
  };
  gst_element_call_async(element_, proceed, this, nullptr);
}

void CollectorPads::configure(const sync::Options& options, OnBackwardsTime backwards,
                              uint64_t max_wait_ns, uint64_t max_bytes) {
  constexpr uint64_t kMax = uint64_t{1} << 60;
  max_wait_ = max_wait_ns;
  backwards_ = backwards;
  const auto wait = std::chrono::nanoseconds(std::min(max_wait_ns, kMax));
  collector_.configure(options, backwards, wait, max_bytes);
}

Status CollectorPads::start() {
  for (const auto& pad : sink_pads())
    if (auto status = can_be_fed(element_, pad.get()); !status) return status;
  begun_ = time_reported_ = false;
  segment_due_ = true;
  specs_.clear();
  {
    std::lock_guard lock(pads_mutex_);
    pending_.clear();
    for (const auto& pad : pads_) {
      pad->fed_by = nullptr;
      pad->last_time.reset();
    }
  }
  collector_.start();
  return ok();
}

void CollectorPads::stop() {
  collector_.stop();
}

void CollectorPads::forget_streams() {
  std::lock_guard lock(pads_mutex_);
  for (const auto& pad : pads_) {
    pad->spec.reset();
    gst_segment_init(&pad->segment, GST_FORMAT_UNDEFINED);
  }
}

void CollectorPads::add_stats(GstStructure* stats) const {
  const auto counts = collector_.counts();
  const auto [held, max] = collector_.bytes_held();
  gst_structure_set(stats, "times-backwards", G_TYPE_UINT64, counts.backwards, "pads-missed",
                    G_TYPE_UINT64, counts.missed, "bytes-held", G_TYPE_UINT64, held, "bytes-most",
                    G_TYPE_UINT64, max, nullptr);
}

GstFlowReturn CollectorPads::chain(Pad& pad, Ref<GstBuffer> buffer) {
  pad.fed_by = g_thread_self();
  if (!pad.spec) {
    refused(buffer_before_caps("other/tensors,format=static,num_tensors=1,...", get_name(pad.pad)));
    ledger_->received();
    ledger_->dropped(DropReason::Error);
    return GST_FLOW_NOT_NEGOTIATED;
  }
  const sync::Stamp time = to_stamp(GST_BUFFER_PTS(buffer.get()));
  sync::Stamp running_time;
  if (time && pad.segment.format == GST_FORMAT_TIME)
    running_time = to_stamp(gst_segment_to_running_time(&pad.segment, GST_FORMAT_TIME, *time));
  watch_time(pad, time);
  const uint64_t bytes = gst_buffer_get_size(buffer.get());
  const int flow =
      collector_.offer(pad.queue, {std::move(buffer), pad.spec, running_time}, time, bytes);
  return static_cast<GstFlowReturn>(flow);
}

// Warns once; `stats` counts each.
void CollectorPads::watch_time(Pad& pad, const sync::Stamp& time) {
  if (!time) return;
  const sync::Stamp last = std::exchange(pad.last_time, time);
  if (!last || *time >= *last || time_reported_.exchange(true)) return;
  Error error = backwards_time(*time, *last, backwards_);
  error.offered += " on " + get_name(pad.pad);
  post_warning(element_, error);
}

Status CollectorPads::negotiate(const Inputs& inputs) {
  const bool reconfigure = gst_pad_check_reconfigure(source_);
  const auto same = [](const Input& input, const auto& spec) { return input.spec == spec; };
  if (!reconfigure && !specs_.empty() &&
      std::equal(inputs.frames.begin(), inputs.frames.end(), specs_.begin(), specs_.end(), same))
    return ok();
  std::vector<const FrameSpec*> specs;
  for (const Input& input : inputs.frames) specs.push_back(input.spec.get());
  auto combined = combiner_->combine_specs(specs);
  if (!combined) return combined.error();
  const auto chosen = choose_caps(source_, PeerCaps(source_), *combined);
  if (!chosen) return send_caps(source_, *combined, nullptr);
  const auto output = fixed_spec_from_caps(chosen.get());
  if (!output) return output.error();
  const auto old = Ref<GstCaps>::adopt(gst_pad_get_current_caps(source_));
  const bool changed = !old || !gst_caps_is_equal(old.get(), chosen.get());
  if (changed) {
    if (auto status = send_caps(source_, *combined, chosen.get()); !status) return status;
    if (GST_PAD_IS_FLUSHING(source_)) {
      specs_.clear();
      return ok();
    }
  }
  if (auto status = combiner_->configure(*output); !status) return status;
  specs_.clear();
  for (const Input& input : inputs.frames) specs_.push_back(input.spec);
  return ok();
}

int CollectorPads::emit(Inputs inputs) {
  return guarded<GstFlowReturn>(element_, [&]() -> GstFlowReturn {
    begin_stream();
    const Status negotiated = negotiate(inputs);
    if (negotiated && specs_.empty()) {  // the combiner is not configured for these inputs
      ledger_->lost(DropReason::Flush, inputs.used_first);
      return GST_FLOW_FLUSHING;
    }
    auto buffer = negotiated ? combiner_->combine(inputs) : negotiated.error();
    if (!buffer) {
      ledger_->lost(DropReason::Error, inputs.used_first);
      post_error(element_, buffer.error());
      return GST_FLOW_ERROR;
    }
    if (!*buffer) {
      push_gap(inputs);
      return GST_FLOW_OK;
    }
    GstBuffer* out = buffer->get();
    if (!combiner_->gives_time()) GST_BUFFER_PTS(out) = inputs.time;
    const sync::Stamp pts = to_stamp(GST_BUFFER_PTS(out));
    const sync::Stamp start = GST_BUFFER_DTS_IS_VALID(out) ? to_stamp(GST_BUFFER_DTS(out)) : pts;
    if (segment_due_.exchange(false))
      begin_segment(start.value_or(0), pts.value_or(0),
                    inputs.frames[inputs.metadata_pad].running_time);
    inputs.frames.clear();
    const GstFlowReturn flow = gst_pad_push(source_, buffer->release());
    if (flow == GST_FLOW_OK) ledger_->pushed();
    return flow;
  });
}

// Informs downstream elements by a GAP event that the time of these frames has passed.
void CollectorPads::push_gap(const Inputs& inputs) {
  const Input& deciding = inputs.frames[inputs.metadata_pad];
  if (segment_due_.exchange(false)) begin_segment(inputs.time, inputs.time, deciding.running_time);
  gst_pad_push_event(source_,
                     gst_event_new_gap(inputs.time, GST_BUFFER_DURATION(deciding.buffer.get())));
}

void CollectorPads::end() {
  guarded<void>(element_, [&] {
    begin_stream();
    if (segment_due_.exchange(false)) begin_segment(0, 0, {});
    gst_pad_push_event(source_, gst_event_new_eos());
  });
}

void CollectorPads::refused(const Error& error) {
  post_error(element_, error);
}

CollectorPads::Pad* CollectorPads::find_pad(sync::QueueId queue) {
  const auto it =
      std::find_if(pads_.begin(), pads_.end(), [queue](auto& p) { return p->queue == queue; });
  return it == pads_.end() ? nullptr : it->get();
}

Status CollectorPads::may_wait(sync::QueueId waiting, const std::vector<sync::QueueId>& empty) {
  Ref<GstPad> own;
  std::vector<Ref<GstPad>> others;
  {
    std::lock_guard lock(pads_mutex_);
    if (const Pad* pad = find_pad(waiting)) own = Ref<GstPad>::share(pad->pad);
    for (const auto queue : empty)
      if (const Pad* pad = find_pad(queue); pad && queue != waiting) {
        GThread* thread = pad->fed_by;
        if (!thread || thread == g_thread_self()) others.push_back(Ref<GstPad>::share(pad->pad));
      }
  }
  for (const auto& other : others)
    if (auto status = can_wait(element_, own.get(), other.get()); own && !status) return status;
  return ok();
}

CollectorPads::WaitNames CollectorPads::wait_names(sync::QueueId waiting,
                                                   const std::vector<sync::QueueId>& others) {
  WaitNames out;
  std::vector<std::string> names;
  std::lock_guard lock(pads_mutex_);
  if (const Pad* pad = find_pad(waiting)) out.waiting = get_name(pad->pad);
  for (const auto queue : others)
    if (const Pad* pad = find_pad(queue)) names.push_back(get_name(pad->pad));
  out.others = join(names, ", ");
  return out;
}

void CollectorPads::waits_for_gap_only_pads(sync::QueueId waiting,
                                            const std::vector<sync::QueueId>& gaps) {
  const auto [own, others] = wait_names(waiting, gaps);
  if (own.empty() || others.empty()) return;
  post_warning(
      element_,
      Error{.code = Code::GRAPH_STALLS,
            .what = "a frame waits for a pad that has only received GAP events",
            .offered = "a frame on " + own + ", and GAP events past its time on " + others,
            .needed = "a frame on " + others + ": in this sync-mode a gap cannot replace it",
            .fix = "max-wait=1000000000"});
}

bool CollectorPads::waits_for_silent_pads(sync::QueueId waiting,
                                          const std::vector<sync::QueueId>& silent) {
  if (GST_STATE(element_) != GST_STATE_PLAYING) return false;  // live sources deliver nothing
  const auto [own, others] = wait_names(waiting, silent);
  if (own.empty() || others.empty()) return false;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(sync::kSilenceTimeout);
  post_warning(element_, Error{.code = Code::GRAPH_STALLS,
                               .what = "a frame has waited " + std::to_string(seconds.count()) +
                                       " s for a pad that receives nothing",
                               .offered = "a frame on " + own + ", and nothing on " + others,
                               .needed = "a frame on " + others +
                                         ", or its end: an output needs a frame of each pad",
                               .fix = "max-wait=1000000000"});
  return true;
}

std::vector<Ref<GstPad>> CollectorPads::sink_pads() {
  std::vector<Ref<GstPad>> out;
  std::lock_guard lock(pads_mutex_);
  for (const auto& pad : pads_) out.push_back(Ref<GstPad>::share(pad->pad));
  return out;
}

}  // namespace weir::gst
