// Bench: one element under test; accepts any input and consumes all outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "elements/tests/bad_input_subjects_test_support.hpp"

namespace weir::testing_bad_input {

using gst::Ref;
using gst::Unique;

class Bench {
 public:
  explicit Bench(const std::string& line) : Bench(Subject{"", line, "", 0}) {}
  explicit Bench(const Subject& subject)
      : subject_(subject),
        element_(test::lone_element(subject.line)),
        bus_(Ref<GstBus>::adopt(gst_bus_new())) {
    gst_bus_set_sync_handler(bus_.get(), on_message, this, nullptr);
    if (!subject.partner.empty()) partner_ = test::lone_element(subject.partner);
    for (const auto& element : {element_, partner_}) attach(element.get());
    GstElement* const owner = is_source() ? partner_.get() : element_.get();
    std::vector<std::string> names{subject.pad};
    for (const auto& companion : subject.companions) names.push_back(companion.pad);
    std::sort(names.begin(), names.end());  // request pads are inputs, in the order of requests
    for (const auto& name : names) sinks_.push_back(sink_pad(owner, name));
    const auto index = [&names](const std::string& name) {
      return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    sink_ = sinks_[index(subject.pad)];
    for (const auto& companion : subject.companions)
      companions_.push_back({companion, sinks_[index(companion.pad)], {}});
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  ~Bench() {
    set_state(GST_STATE_NULL);
    companions_.clear();
    for (const auto& element : {element_, partner_}) {
      if (!element) continue;
      g_signal_handlers_disconnect_by_data(element.get(), this);
      gst_element_set_bus(element.get(), nullptr);
    }
    for (const auto& end : ends_) gst_pad_set_active(end.get(), FALSE);
  }

  // Starts a stream with these caps and plays it; returns "" or the error.
  std::string start(const std::string& caps) {
    if (std::string error = play(); !error.empty()) return error;
    const std::string error = set_caps(caps);
    if (error.empty()) gst_pad_send_event(sink_.get(), test::time_segment());
    return error;
  }
  std::string start_without_caps() {
    if (std::string error = play(); !error.empty()) return error;
    gst_pad_send_event(sink_.get(), test::time_segment());
    return "";
  }
  std::string set_caps(const std::string& text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
    EXPECT_TRUE(caps) << text;
    if (gst_pad_send_event(sink_.get(), gst_event_new_caps(caps.get()))) return "";
    return message_text(GST_MESSAGE_ERROR, "rejected the caps");
  }
  void begin_segment(GstFormat format) {
    GstSegment segment;
    gst_segment_init(&segment, format);
    gst_pad_send_event(sink_.get(), gst_event_new_segment(&segment));
  }
  // Queries all pads about these caps; returns "" or the error that the element posted.
  std::string query(const std::string& text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
    EXPECT_TRUE(caps) << text;
    for (const auto* list : {element_.get()->sinkpads, element_.get()->srcpads})
      for (; list; list = list->next) {
        auto* const pad = static_cast<GstPad*>(list->data);
        const auto found = Ref<GstCaps>::adopt(gst_pad_query_caps(pad, caps.get()));
        if (!gst_caps_is_fixed(caps.get())) continue;
        gst_pad_query_accept_caps(pad, caps.get());
        if (!GST_PAD_IS_SINK(pad)) continue;
        const Unique<GstQuery, gst_query_unref> allocation(
            gst_query_new_allocation(caps.get(), TRUE));
        gst_pad_query(pad, allocation.get());
      }
    return message_text(GST_MESSAGE_ERROR, "");
  }
  // Returns "" when the buffer was accepted.
  std::string push(GstBuffer* buffer) {
    for (auto& companion : companions_)
      if (companion.what.brings == Companion::Brings::EachFrame) bring(companion);
    const GstFlowReturn flow = gst_pad_chain(sink_.get(), buffer);
    if (flow != GST_FLOW_OK) return message_text(GST_MESSAGE_ERROR, gst_flow_get_name(flow));
    for (auto& companion : companions_)  // their frames were used with the buffer
      if (companion.push.valid()) companion.push.get();
    return is_source() ? error_of_source() : "";
  }
  std::string warning() { return message_text(GST_MESSAGE_WARNING, ""); }
  void stop() {
    set_state(GST_STATE_READY);
    for (auto& companion : companions_) companion.push = {};
    companion_frames_ = 0;
    for (const auto& end : ends_) {
      gst_pad_set_active(end.get(), FALSE);
      gst_pad_set_active(end.get(), TRUE);
    }
    gst_bus_set_flushing(bus_.get(), TRUE);
    gst_bus_set_flushing(bus_.get(), FALSE);
  }
  uint64_t stat(const char* name) const { return test::stat(element_.get(), name); }
  // Buffers received by the input under test; 0 if nothing counts them.
  uint64_t received() const {
    return *subject_.counter ? stat(subject_.counter) - companion_frames_ : 0;
  }
  // The value of the property when the last error was posted.
  uint64_t dropped_with_warning() const { return dropped_with_warning_; }
  uint64_t outputs() const { return outputs_; }
  // Keeps the bytes of the outputs from now on.
  void keep_bytes() { keeps_ = true; }
  const std::vector<uint8_t>& bytes() const { return bytes_; }  // of all outputs
  GstClockTime last_time() const { return last_time_; }
  bool has_output() const {
    return subject_.makes_outputs && GST_ELEMENT_CAST(element_.get())->srcpads != nullptr;
  }
  // The input under test must have received `received` buffers.
  void expect_balance(uint64_t received) const {
    if (*subject_.counter) {
      EXPECT_EQ(this->received(), received);
    }
    const auto all = test::stats(element_.get());
    const auto number = [&all](const char* name) {
      guint64 value = 0;
      EXPECT_TRUE(gst_structure_get_uint64(all.get(), name, &value)) << name;
      return value;
    };
    EXPECT_EQ(number("received"), number("consumed") + number("dropped") + number("held"));
    EXPECT_LE(number("held"), number("received"));
  }

 private:
  static inline GstStaticPadTemplate kAnything =
      GST_STATIC_PAD_TEMPLATE("end", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);

  struct Running {
    Companion what;
    Ref<GstPad> pad;
    std::future<GstFlowReturn> push;
  };

  // The element under test has no input: buffers for its partner reach it.
  bool is_source() const { return GST_OBJECT_FLAG_IS_SET(element_.get(), GST_ELEMENT_FLAG_SOURCE); }

  void attach(GstElement* element) {
    if (!element) return;
    gst_element_set_bus(element, bus_.get());
    g_signal_connect(element, "pad-added", G_CALLBACK(on_pad), this);
    const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(element, "src"));
    if (source) pull_all(source.get());
  }
  static Ref<GstPad> sink_pad(GstElement* element, const std::string& name) {
    if (!element) return {};  // only the source
    auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element, name.c_str()));
    if (!pad) pad = Ref<GstPad>::adopt(gst_element_request_pad_simple(element, name.c_str()));
    return pad;
  }
  void pull_all(GstPad* source) {
    auto end = test::lone_pad(gst_pad_new_from_static_template(&kAnything, "end"));
    gst_pad_set_element_private(end.get(), this);
    gst_pad_set_chain_function(end.get(), take);
    gst_pad_set_active(end.get(), TRUE);
    gst_pad_link(source, end.get());
    ends_.push_back(std::move(end));
  }
  static void on_pad(GstElement*, GstPad* pad, gpointer self) {
    if (GST_PAD_IS_SRC(pad)) static_cast<Bench*>(self)->pull_all(pad);
  }

  GstStateChangeReturn set_state(GstState state) {
    const auto result = gst_element_set_state(element_.get(), state);
    if (partner_) gst_element_set_state(partner_.get(), state);
    return result;
  }
  std::string play() {
    if (set_state(GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
      return message_text(GST_MESSAGE_ERROR, "did not start");
    for (auto& companion : companions_) begin(companion);
    gst_pad_send_event(sink_.get(), gst_event_new_stream_start("bench"));
    return "";
  }
  void begin(Running& companion) {
    GstPad* const pad = companion.pad.get();
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(companion.what.caps.c_str()));
    gst_pad_send_event(pad, gst_event_new_stream_start("companion"));
    EXPECT_TRUE(gst_pad_send_event(pad, gst_event_new_caps(caps.get())));
    gst_pad_send_event(pad, test::time_segment());
    if (companion.what.brings == Companion::Brings::OneFrame) bring(companion);
  }
  // Pushes on a separate thread, because the frame waits for its partner; one at a time.
  void bring(Running& companion) {
    using namespace std::chrono_literals;
    // A frame without a partner still waits.
    if (companion.push.valid() && companion.push.wait_for(0s) != std::future_status::ready) return;
    const uint64_t before = stat("received");
    ++companion_frames_;
    companion.push = std::async(std::launch::async, [pad = companion.pad, &companion] {
      return gst_pad_chain(pad.get(), buffer_with(companion.what.frame));
    });
    EXPECT_TRUE(becomes_true([&] { return stat("received") > before; }, "the other input"));
    if (companion.what.brings == Companion::Brings::OneFrame) companion.push.get();
  }
  // The error of the source for the buffer that its partner accepted.
  std::string error_of_source() {
    const auto settled = [this] {
      const uint64_t handed_on = test::stat(partner_.get(), "consumed");
      return test::stat(partner_.get(), "held") == 0 && stat("received") == handed_on &&
             stat("held") == 0;
    };
    EXPECT_TRUE(becomes_true(settled, "the source"));
    if (stat("dropped") == 0) return "";
    const auto message = Ref<GstMessage>::adopt(
        gst_bus_timed_pop_filtered(bus_.get(), 10 * GST_SECOND, GST_MESSAGE_ERROR));
    return test::get_text(message.get());
  }

  static GstBusSyncReply on_message(GstBus*, GstMessage* message, gpointer self) {
    auto* bench = static_cast<Bench*>(self);
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
      bench->dropped_with_warning_ = bench->stat("dropped");
    return GST_BUS_PASS;
  }
  static GstFlowReturn take(GstPad* pad, GstObject*, GstBuffer* buffer) {
    auto* bench = static_cast<Bench*>(gst_pad_get_element_private(pad));
    ++bench->outputs_;
    bench->last_time_ = GST_BUFFER_PTS(buffer);
    if (bench->keeps_) {
      const gst::Mapped map(buffer, GST_MAP_READ);
      EXPECT_TRUE(map);
      const auto bytes = map.as<const uint8_t>();
      bench->bytes_.insert(bench->bytes_.end(), bytes.begin(), bytes.end());
    }
    gst_buffer_unref(buffer);
    return GST_FLOW_OK;
  }
  std::string message_text(GstMessageType type, const char* otherwise) {
    const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus_.get(), type));
    return message ? test::get_text(message.get()) : otherwise;
  }

  const Subject subject_;
  Ref<GstElement> element_, partner_;
  Ref<GstBus> bus_;
  std::vector<Ref<GstPad>> sinks_, ends_;
  Ref<GstPad> sink_;
  std::vector<Running> companions_;
  uint64_t companion_frames_ = 0;
  std::atomic<uint64_t> outputs_ = 0, dropped_with_warning_ = 0;
  std::atomic<GstClockTime> last_time_ = GST_CLOCK_TIME_NONE;
  bool keeps_ = false;
  std::vector<uint8_t> bytes_;
};

// After a fault the ledger must balance, and after READY the element must work normally.
inline void expect_sound_again(Bench& bench, const Subject& subject, uint64_t received) {
  bench.expect_balance(received);
  bench.stop();
  EXPECT_EQ(bench.start(subject.caps), "") << "after READY";
  const uint64_t before = bench.outputs();
  for (GstClockTime i = 0; i < 2; ++i) {
    GstBuffer* in = subject.good_frame();
    GST_BUFFER_PTS(in) = i * GST_SECOND / 30;
    EXPECT_EQ(bench.push(in), "") << "after READY";
  }
  if (bench.has_output()) {
    EXPECT_TRUE(becomes_true([&] { return bench.outputs() > before; }, "an output"));
  }
  bench.expect_balance(2);
}

class EachElement : public ::testing::TestWithParam<Subject> {};

#define WEIR_FOR_EACH_OF(Suite, Subjects)                             \
  INSTANTIATE_TEST_SUITE_P(All, Suite, ::testing::ValuesIn(Subjects), \
                           [](const auto& info) { return std::string(info.param.name); })
#define WEIR_FOR_EACH_ELEMENT(Suite) WEIR_FOR_EACH_OF(Suite, subjects())

}  // namespace weir::testing_bad_input
