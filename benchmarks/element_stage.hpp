// ElementStage: drives one element, or several in a row, between two bare pads from this thread. A
// sink has no second pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"

namespace weir::bench {

class ElementStage {
 public:
  ElementStage(const std::string& launch, const char* caps, size_t bytes)
      : element_(make_element(launch)),
        pool_(gst::Ref<GstBufferPool>::adopt(gst_buffer_pool_new())) {
    source_ = gst_pad_new("source", GST_PAD_SRC);
    sink_ = gst_pad_new("sink", GST_PAD_SINK);
    gst_object_ref_sink(source_);
    gst_object_ref_sink(sink_);
    gst_pad_set_chain_function(sink_, [](GstPad*, GstObject*, GstBuffer* buffer) {
      gst_buffer_unref(buffer);
      return GST_FLOW_OK;
    });
    const auto in = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "sink"));
    const auto out = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"));
    gst_pad_link(source_, in.get());
    if (out) gst_pad_link(out.get(), sink_);
    gst_pad_set_active(sink_, TRUE);
    gst_pad_set_active(source_, TRUE);
    gst_element_set_state(element_.get(), GST_STATE_PLAYING);
    const auto format = gst::Ref<GstCaps>::adopt(gst_caps_from_string(caps));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source_, gst_event_new_stream_start("benchmark"));
    if (!gst_pad_push_event(source_, gst_event_new_caps(format.get())))
      throw std::runtime_error(launch + " does not take " + caps);
    gst_pad_push_event(source_, gst_event_new_segment(&segment));
    GstStructure* config = gst_buffer_pool_get_config(pool_.get());
    gst_buffer_pool_config_set_params(config, nullptr, static_cast<guint>(bytes), 4, 0);
    gst_buffer_pool_set_config(pool_.get(), config);
    gst_buffer_pool_set_active(pool_.get(), TRUE);
  }
  ~ElementStage() {
    gst_element_set_state(element_.get(), GST_STATE_NULL);
    gst_pad_set_active(source_, FALSE);
    gst_pad_set_active(sink_, FALSE);
    gst_object_unref(source_);
    gst_object_unref(sink_);
    gst_buffer_pool_set_active(pool_.get(), FALSE);
  }
  ElementStage(const ElementStage&) = delete;
  ElementStage& operator=(const ElementStage&) = delete;

  // `prepare` is called with each buffer before it is pushed.
  void push(int count, const std::function<void(GstBuffer*)>& prepare = {}) {
    for (int i = 0; i < count; ++i) {
      GstBuffer* buffer = nullptr;
      gst_buffer_pool_acquire_buffer(pool_.get(), &buffer, nullptr);
      GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(pushed_++) * GST_MSECOND;
      if (prepare) prepare(buffer);
      if (gst_pad_push(source_, buffer) != GST_FLOW_OK)
        throw std::runtime_error("a frame was refused");
    }
  }
  // For a single element; a pad other than those that frames pass.
  gst::Ref<GstPad> pad(const char* name) const {
    return gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), name));
  }
  // For a single element.
  uint64_t stat(const char* name) const {
    GstStructure* raw = nullptr;
    g_object_get(element_.get(), "stats", &raw, nullptr);
    const gst::Unique<GstStructure, gst_structure_free> stats(raw);
    guint64 value = 0;
    gst_structure_get_uint64(stats.get(), name, &value);
    return value;
  }

 private:
  static gst::Ref<GstElement> make_element(const std::string& launch) {
    const auto made = launched(launch);
    if (!GST_IS_BIN(made.get())) return made;
    return gst::Ref<GstElement>::adopt(GST_ELEMENT(
        gst_object_ref_sink(gst_parse_bin_from_description(launch.c_str(), TRUE, nullptr))));
  }

  gst::Ref<GstElement> element_;
  gst::Ref<GstBufferPool> pool_;
  GstPad *source_ = nullptr, *sink_ = nullptr;
  int64_t pushed_ = 0;
};

}  // namespace weir::bench
