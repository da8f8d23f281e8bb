// BranchStage: drives an element with sometimes source pads from this thread, with frames of
// several memories.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"

namespace weir::bench {

class BranchStage {
 public:
  // `bytes`: sizes of the memories of a frame.
  BranchStage(const std::string& launch, const std::string& caps, const std::vector<size_t>& bytes)
      : element_(launched(launch)) {
    for (const size_t size : bytes) {
      memories_.push_back(gst::Ref<GstMemory>::adopt(gst_allocator_alloc(nullptr, size, nullptr)));
      const gst::MappedMemory map(memories_.back().get(), GST_MAP_WRITE);
      std::fill(map.bytes().begin(), map.bytes().end(), std::byte{1});
    }
    g_signal_connect(element_.get(), "pad-added", G_CALLBACK(join), this);
    if (const auto out = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src")))
      join(element_.get(), out.get(), this);
    source_ =
        gst::Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("source", GST_PAD_SRC))));
    const auto in = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "sink"));
    gst_pad_link(source_.get(), in.get());
    gst_pad_set_active(source_.get(), TRUE);
    gst_element_set_state(element_.get(), GST_STATE_PLAYING);
    const auto format = gst::Ref<GstCaps>::adopt(gst_caps_from_string(caps.c_str()));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source_.get(), gst_event_new_stream_start("benchmark"));
    if (!gst_pad_push_event(source_.get(), gst_event_new_caps(format.get())))
      throw std::runtime_error(launch + " does not take " + caps);
    gst_pad_push_event(source_.get(), gst_event_new_segment(&segment));
  }
  ~BranchStage() {
    gst_element_set_state(element_.get(), GST_STATE_NULL);
    gst_pad_set_active(source_.get(), FALSE);
    for (const auto& pad : sinks_) gst_pad_set_active(pad.get(), FALSE);
  }
  BranchStage(const BranchStage&) = delete;
  BranchStage& operator=(const BranchStage&) = delete;

  void push(int count) {
    for (int i = 0; i < count; ++i) {
      GstBuffer* buffer = gst_buffer_new();
      for (const auto& memory : memories_)
        gst_buffer_append_memory(buffer, gst_memory_ref(memory.get()));
      GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(pushed_++) * GST_MSECOND;
      if (gst_pad_push(source_.get(), buffer) != GST_FLOW_OK)
        throw std::runtime_error("a frame was refused");
    }
  }

 private:
  static void join(GstElement*, GstPad* pad, gpointer data) {
    if (GST_PAD_IS_SINK(pad)) return;
    GstPad* sink = gst_pad_new(nullptr, GST_PAD_SINK);
    auto* self = static_cast<BranchStage*>(data);
    self->sinks_.push_back(gst::Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(sink))));
    gst_pad_set_chain_function(sink, [](GstPad*, GstObject*, GstBuffer* buffer) {
      gst_buffer_unref(buffer);
      return GST_FLOW_OK;
    });
    gst_pad_set_active(sink, TRUE);
    gst_pad_link(pad, sink);
  }

  gst::Ref<GstElement> element_;
  std::vector<gst::Ref<GstMemory>> memories_;
  gst::Ref<GstPad> source_;
  std::vector<gst::Ref<GstPad>> sinks_;
  int64_t pushed_ = 0;
};

}  // namespace weir::bench
