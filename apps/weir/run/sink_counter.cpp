// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/sink_counter.hpp"

#include <algorithm>
#include <string_view>

#include "gstcpp/element/elements.hpp"
#include "run/muxed_files.hpp"

namespace weir::app {
namespace {

bool comes_from_a_muxer(GstPad* pad) {
  const auto peer = gst::Ref<GstPad>::adopt(gst_pad_get_peer(pad));
  const auto upstream =
      gst::Ref<GstElement>::adopt(peer ? gst_pad_get_parent_element(peer.get()) : nullptr);
  return upstream && is_muxer(upstream.get());
}

}  // namespace

SinkCounter::SinkCounter(GstElement* pipeline) : pipeline_(gst::Ref<GstElement>::share(pipeline)) {
  g_signal_connect(pipeline, "deep-element-added",
                   G_CALLBACK(+[](GstBin*, GstBin*, GstElement* element, gpointer self) {
                     static_cast<SinkCounter*>(self)->watch(element);
                   }),
                   this);
  for (const auto& element : gst::elements_in(pipeline)) watch(element.get());
}

SinkCounter::~SinkCounter() {
  g_signal_handlers_disconnect_by_data(pipeline_.get(), this);
}

void SinkCounter::watch(GstElement* element) {
  const bool muxes = is_muxer(element);
  if (!muxes && !is_sink(element)) return;
  for (GList* item = element->sinkpads; item; item = item->next)
    watch(element, GST_PAD(item->data), muxes);
  // Pads for streams that a demuxer finds later. None is added in state NULL.
  if (muxes)
    g_signal_connect(element, "pad-added",
                     G_CALLBACK(+[](GstElement* muxer, GstPad* pad, gpointer self) {
                       if (gst_pad_get_direction(pad) == GST_PAD_SINK)
                         static_cast<SinkCounter*>(self)->watch(muxer, pad, true);
                     }),
                     this);
}

void SinkCounter::watch(GstElement* element, GstPad* pad, bool is_muxer) {
  auto count = std::make_unique<Count>();
  const gst::UniqueText name(gst_element_get_name(element));
  count->name = name.get();
  count->is_muxer = is_muxer;
  count->first = &first_;
  gst_pad_add_probe(
      pad, static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST),
      on_data, count.get(), nullptr);
  std::lock_guard lock(mutex_);
  counts_.push_back(std::move(count));
}

SinkCounter::Kind SinkCounter::find_kind(GstPad* pad) {
  const auto caps = gst::Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad));
  if (!caps || gst_caps_get_size(caps.get()) == 0 || comes_from_a_muxer(pad)) return Kind::Buffers;
  const std::string_view type = gst_structure_get_name(gst_caps_get_structure(caps.get(), 0));
  const bool is_frames =
      type.starts_with("video/") || type.starts_with("image/") || type.starts_with("other/tensor");
  return is_frames ? Kind::Frames : Kind::Buffers;
}

GstPadProbeReturn SinkCounter::on_data(GstPad* pad, GstPadProbeInfo* info, gpointer user) {
  auto* sink = static_cast<Count*>(user);
  if (sink->kind == Kind::Unknown) sink->kind = find_kind(pad);
  if (!sink->is_muxer) {
    gint64 never = 0;
    if (sink->first->load(std::memory_order_relaxed) == 0)
      sink->first->compare_exchange_strong(never, g_get_monotonic_time());
  }
  const bool list = info->type & GST_PAD_PROBE_TYPE_BUFFER_LIST;
  // Codecs send headers ahead of the frames.
  if (!list && sink->kind == Kind::Frames &&
      GST_BUFFER_FLAG_IS_SET(GST_PAD_PROBE_INFO_BUFFER(info), GST_BUFFER_FLAG_HEADER))
    return GST_PAD_PROBE_OK;
  sink->count += list ? gst_buffer_list_length(GST_PAD_PROBE_INFO_BUFFER_LIST(info)) : 1;
  return GST_PAD_PROBE_OK;
}

std::vector<SinkStatistics> SinkCounter::statistics() const {
  std::vector<SinkStatistics> out;
  std::lock_guard lock(mutex_);
  for (const auto& sink : counts_) {
    const bool is_frames = sink->kind != Kind::Buffers;
    if (!sink->is_muxer || sink->kind == Kind::Frames)
      out.push_back({sink->name, sink->count, is_frames});
  }
  return out;
}

SinkStatistics SinkCounter::total() const {
  const auto all = statistics();
  SinkStatistics out;
  const auto has = [&all](bool frames) {
    return std::any_of(all.begin(), all.end(), [frames](const SinkStatistics& one) {
      return one.is_frames == frames && one.count > 0;
    });
  };
  out.is_frames = has(true) || !has(false);
  for (const auto& one : all)
    if (one.is_frames == out.is_frames) out.count += one.count;
  return out;
}

uint64_t SinkCounter::busiest() const {
  const bool is_frames = total().is_frames;
  uint64_t max = 0;
  for (const auto& one : statistics())
    if (one.is_frames == is_frames) max = std::max(max, one.count);
  return max;
}

}  // namespace weir::app
