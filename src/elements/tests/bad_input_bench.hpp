// One element between a hand that pushes anything and a pad that takes everything.
#pragma once
#include <gst/gst.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "elements/tests/element_parts.hpp"

namespace weir::testing_bad_input {

using gst::Ref;
using gst::Unique;

class Bench {
 public:
  explicit Bench(const std::string& line)
      : element_(test::lone_element(line)),
        bus_(Ref<GstBus>::adopt(gst_bus_new())),
        sink_(Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "sink"))),
        end_(test::lone_pad(gst_pad_new_from_static_template(&kAnything, "end"))) {
    gst_element_set_bus(element_.get(), bus_.get());
    gst_bus_set_sync_handler(bus_.get(), told, this, nullptr);
    gst_pad_set_element_private(end_.get(), this);
    gst_pad_set_chain_function(end_.get(), take);
    gst_pad_set_active(end_.get(), TRUE);
    const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"));
    if (source) gst_pad_link(source.get(), end_.get());
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  ~Bench() {
    gst_element_set_state(element_.get(), GST_STATE_NULL);
    gst_element_set_bus(element_.get(), nullptr);
    gst_pad_set_active(end_.get(), FALSE);
  }

  // Plays from the start of a stream with these caps; "" or the error.
  std::string start(const std::string& caps) {
    if (gst_element_set_state(element_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
      return said(GST_MESSAGE_ERROR, "did not start");
    gst_pad_send_event(sink_.get(), gst_event_new_stream_start("bench"));
    const std::string error = set_caps(caps);
    if (error.empty()) gst_pad_send_event(sink_.get(), test::time_segment());
    return error;
  }
  std::string start_without_caps() {
    if (gst_element_set_state(element_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
      return said(GST_MESSAGE_ERROR, "did not start");
    gst_pad_send_event(sink_.get(), gst_event_new_stream_start("bench"));
    gst_pad_send_event(sink_.get(), test::time_segment());
    return "";
  }
  std::string set_caps(const std::string& text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
    EXPECT_TRUE(caps) << text;
    if (gst_pad_send_event(sink_.get(), gst_event_new_caps(caps.get()))) return "";
    return said(GST_MESSAGE_ERROR, "refused the caps");
  }
  // "" when the buffer was taken.
  std::string push(GstBuffer* buffer) {
    const GstFlowReturn flow = gst_pad_chain(sink_.get(), buffer);
    if (flow == GST_FLOW_OK) return "";
    return said(GST_MESSAGE_ERROR, gst_flow_get_name(flow));
  }
  std::string warning() { return said(GST_MESSAGE_WARNING, ""); }
  void stop() {
    gst_element_set_state(element_.get(), GST_STATE_READY);
    gst_pad_set_active(end_.get(), FALSE);
    gst_pad_set_active(end_.get(), TRUE);
    gst_bus_set_flushing(bus_.get(), TRUE);
    gst_bus_set_flushing(bus_.get(), FALSE);
  }
  uint64_t stat(const char* name) const { return test::stat(element_.get(), name); }
  // What the property said when the last error was posted.
  uint64_t dropped_when_told() const { return dropped_when_told_; }
  uint64_t outputs() const { return outputs_; }
  // From here on the bytes of outputs are kept.
  void keep_bytes() { keeps_ = true; }
  const std::vector<uint8_t>& bytes() const { return bytes_; }  // of all of them
  GstClockTime last_time() const { return last_time_; }
  bool has_output() const {
    const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"));
    return static_cast<bool>(source);
  }
  void expect_balance(uint64_t received) const {
    EXPECT_EQ(stat("received"), received);
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped") + stat("held"));
    EXPECT_LE(stat("held"), stat("received"));
  }

 private:
  static inline GstStaticPadTemplate kAnything =
      GST_STATIC_PAD_TEMPLATE("end", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);

  static GstBusSyncReply told(GstBus*, GstMessage* message, gpointer self) {
    auto* bench = static_cast<Bench*>(self);
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
      bench->dropped_when_told_ = bench->stat("dropped");
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
  std::string said(GstMessageType type, const char* otherwise) {
    const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus_.get(), type));
    return message ? test::text_of(message.get()) : otherwise;
  }

  Ref<GstElement> element_;
  Ref<GstBus> bus_;
  Ref<GstPad> sink_, end_;
  uint64_t outputs_ = 0, dropped_when_told_ = 0;
  bool keeps_ = false;
  std::vector<uint8_t> bytes_;
  GstClockTime last_time_ = GST_CLOCK_TIME_NONE;
};

// An element with caps and the size of a frame that it takes.
struct Subject {
  const char* name;
  std::string line, caps;
  size_t bytes;
};

inline GstBuffer* zeros(size_t bytes) {
  GstBuffer* buffer = gst_buffer_new_allocate(nullptr, bytes, nullptr);
  gst_buffer_memset(buffer, 0, 0, bytes);
  return buffer;
}
inline std::string tensors(const std::string& dims, const std::string& type,
                           const std::string& rate = "30/1") {
  return test::tensors(type, dims, rate);
}
inline std::string video(const std::string& format, int width, int height,
                         const std::string& rate = "30/1") {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",interlace-mode=progressive,framerate=" + rate;
}
inline std::string fake_filter() {
  const std::string path = testing::TempDir() + "weir-bad-input.bin";
  std::ofstream(path) << "the engine looks at nothing of it";
  return "tensor_filter framework=fake model=" + path;
}

// Every element, and its ways of work that differ in how they read.
inline const std::vector<Subject>& subjects() {
  static const std::vector<Subject> all{
      {"converter", "tensor_converter", video("RGB", 8, 4), 96},
      {"converter_chunks", "tensor_converter frames-per-tensor=2", video("RGB", 8, 4), 96},
      {"converter_audio", "tensor_converter",
       "audio/x-raw,format=S16LE,layout=interleaved,rate=8000,channels=2", 64},
      {"converter_bytes", "tensor_converter input-dim=16 input-type=uint8",
       "application/octet-stream,framerate=30/1", 16},
      {"preprocess", "tensor_preprocess width=4 height=4", video("RGB", 8, 4), 96},
      {"preprocess_yuv", "tensor_preprocess width=4 height=4 method=area", video("NV12", 8, 4), 48},
      {"transform_type", "tensor_transform mode=typecast option=float32", tensors("4:4", "uint8"),
       16},
      {"transform_in_place", "tensor_transform mode=arithmetic option=add:1",
       tensors("4:4", "uint8"), 16},
      {"transform_order", "tensor_transform mode=transpose option=1:0:2:3", tensors("4:4", "uint8"),
       16},
      {"filter", fake_filter(), tensors("4:4", "float32"), 64},
      {"decoder", "tensor_decoder mode=octet_stream", tensors("4:4", "uint8"), 16},
      {"decoder_video", "tensor_decoder mode=direct_video", tensors("3:4:4", "uint8"), 48},
      {"overlay", "tensor_overlay", video("NV12", 8, 4), 48},
      {"sink", "tensor_sink", tensors("4:4", "uint8"), 16},
  };
  return all;
}

// After a fault: the ledger adds up, and from READY on the element works as if nothing was.
inline void expect_sound_again(Bench& bench, const Subject& subject, uint64_t received) {
  bench.expect_balance(received);
  bench.stop();
  EXPECT_EQ(bench.start(subject.caps), "") << "after READY";
  const uint64_t before = bench.outputs();
  for (int i = 0; i < 2; ++i) EXPECT_EQ(bench.push(zeros(subject.bytes)), "") << "after READY";
  if (bench.has_output()) {
    EXPECT_GT(bench.outputs(), before);
  }
  bench.expect_balance(2);
}

inline void PrintTo(const Subject& subject, std::ostream* out) {
  *out << subject.name;
}

class EachElement : public testing::TestWithParam<Subject> {};

#define WEIR_FOR_EACH_ELEMENT(Suite)                                  \
  INSTANTIATE_TEST_SUITE_P(All, Suite, testing::ValuesIn(subjects()), \
                           [](const auto& info) { return std::string(info.param.name); })

}  // namespace weir::testing_bad_input
