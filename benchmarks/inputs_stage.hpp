// InputsStage: an element with many inputs between bare pads, with one thread per input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "launched.hpp"

namespace weir::bench {

struct InputLine {
  const char* pad;  // "sink_%u" is a request pad
  std::string caps;
  gst::Ref<GstBuffer> buffer;  // pushed repeatedly
};

class InputsStage {
 public:
  // `downstream`: elements with one input, linked downstream in a row.
  InputsStage(const std::string& launch, std::vector<InputLine> inputs,
              const std::vector<std::string>& downstream = {})
      : element_(launched(launch)), inputs_(std::move(inputs)) {
    sink_ =
        gst::Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new("sink", GST_PAD_SINK))));
    gst_pad_set_chain_function(sink_.get(), [](GstPad*, GstObject*, GstBuffer* buffer) {
      gst_buffer_unref(buffer);
      return GST_FLOW_OK;
    });
    auto out = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"));
    for (const std::string& line : downstream) {
      GstElement* const element = downstream_.emplace_back(launched(line)).get();
      const auto in = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element, "sink"));
      gst_pad_link(out.get(), in.get());
      out = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element, "src"));
      gst_element_set_state(element, GST_STATE_PLAYING);
    }
    gst_pad_link(out.get(), sink_.get());
    gst_pad_set_active(sink_.get(), TRUE);
    for (const InputLine& input : inputs_) add(input);
    gst_element_set_state(element_.get(), GST_STATE_PLAYING);
    for (size_t i = 0; i < inputs_.size(); ++i) begin(sources_[i].get(), inputs_[i].caps);
  }
  ~InputsStage() {
    gst_element_set_state(element_.get(), GST_STATE_NULL);
    for (const auto& element : downstream_) gst_element_set_state(element.get(), GST_STATE_NULL);
    for (const auto& source : sources_) gst_pad_set_active(source.get(), FALSE);
    gst_pad_set_active(sink_.get(), FALSE);
  }
  InputsStage(const InputsStage&) = delete;
  InputsStage& operator=(const InputsStage&) = delete;

  void push(int frames) {
    std::vector<std::thread> threads;
    for (size_t i = 0; i < inputs_.size(); ++i)
      threads.emplace_back([this, i, frames] {
        for (int n = 0; n < frames; ++n)
          if (gst_pad_push(sources_[i].get(), gst_buffer_ref(inputs_[i].buffer.get())) !=
              GST_FLOW_OK)
            std::abort();
      });
    for (auto& thread : threads) thread.join();
  }

 private:
  void add(const InputLine& input) {
    auto sink = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), input.pad));
    if (!sink)
      sink = gst::Ref<GstPad>::adopt(gst_element_request_pad_simple(element_.get(), input.pad));
    sources_.push_back(
        gst::Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new(nullptr, GST_PAD_SRC)))));
    gst_pad_set_active(sources_.back().get(), TRUE);
    gst_pad_link(sources_.back().get(), sink.get());
  }
  static void begin(GstPad* source, const std::string& text) {
    const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_push_event(source, gst_event_new_stream_start("benchmark"));
    if (!gst_pad_push_event(source, gst_event_new_caps(caps.get())))
      throw std::runtime_error("not taken: " + text);
    gst_pad_push_event(source, gst_event_new_segment(&segment));
  }

  gst::Ref<GstElement> element_;
  std::vector<gst::Ref<GstElement>> downstream_;
  gst::Ref<GstPad> sink_;
  std::vector<InputLine> inputs_;
  std::vector<gst::Ref<GstPad>> sources_;
};

}  // namespace weir::bench
