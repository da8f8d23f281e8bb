// Tests of NNStreamer converters in tensor_converter: sub_plugins/converter.c is built with our
// headers, bare_converter.c with structs laid out by hand; also functions of this program.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <memory>
#include <stdexcept>

#include "elements/tensor_converter/converter_test_support.hpp"
#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_util.h"
#include "sub_plugin_test_support.hpp"
#include "tensor_converter_custom.h"

namespace weir::testing_tensor_converter {
namespace sub_plugin_converters_test {

std::string caps(const std::string& what = "", const std::string& name = "bytes") {
  return "x-test/" + name + (what.empty() ? "" : ",what=(string)" + what) + ",framerate=10/1";
}
// The output; an empty buffer when there is none.
Ref<GstBuffer> converted(const Harness& h, const Bytes& bytes) {
  EXPECT_EQ(get_error(h, frame(bytes, 5)), "");
  GstBuffer* out = gst_harness_try_pull(h.get());
  return Ref<GstBuffer>::adopt(out ? out : gst_buffer_new());
}
std::string message(const std::string& what) {
  auto h = harness("", caps(what));
  return get_error(h, frame({1, 2, 3}));
}

TEST(SubPluginConverter, AcceptsTheCapsThatItDeclares) {
  auto h = harness("", caps());
  EXPECT_SAYS(caps_text(h), "dimensions=(string)4:1, types=(string)uint8");
  const auto out = converted(h, {1, 2, 3});
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3}));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5u) << "the input's, where the converter gives none";
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:1, types=(string)uint8");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  EXPECT_EQ(content(converted(h, {4, 5}).get()), (Bytes{4, 5})) << "each frame has its own";
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:1");
  EXPECT_EQ(stat(h, "consumed"), 2u);
}

TEST(SubPluginConverter, NeedsNoHeaderAndNoLibraryOfWeir) {
  auto h = harness("", caps("", "bare"));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:1, types=(string)int16");
  const auto out = converted(h, {1, 200, 3});
  EXPECT_EQ(test::values<int16_t>(out.get()), (std::vector<int16_t>{1, -1, 200, -200, 3, -3}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:3, types=(string)int16");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
}

TEST(SubPluginConverter, IsInThePadTemplateAndListed) {
  auto h = harness("", caps());
  EXPECT_SAYS(accepted(h, "x-test/bytes"), "x-test/bytes");
  EXPECT_EQ(accepted(h, "x-test/unknown"), "EMPTY");
  gchar* raw = nullptr;
  g_object_get(find_element(h, "tensor_converter").get(), "sub-plugins", &raw, nullptr);
  const weir::gst::UniqueText list{raw};
  EXPECT_SAYS("," + std::string(list.get()) + ",", ",bytes,");
}

TEST(SubPluginConverter, CanReturnItsInputInEveryWay) {
  for (const char* what : {"same", "same-referenced"}) {
    auto h = harness("", caps(what));
    EXPECT_EQ(content(converted(h, {1, 2, 3}).get()), (Bytes{1, 2, 3})) << what;
  }
  auto h = harness("", caps("changed"));
  GstBuffer* in = frame({1, 2, 3});
  const auto kept = Ref<GstBuffer>::share(in);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(content(out.get()), (Bytes{9, 2, 3}));
  EXPECT_EQ(content(kept.get()), (Bytes{1, 2, 3})) << "others still hold the input";
}

TEST(SubPluginConverter, CanProduceSeveralTensorsAndItsOwnRate) {
  auto two = harness("", caps("two"));
  EXPECT_EQ(content(converted(two, {1, 2, 3}).get()), (Bytes{1, 2, 3}));
  EXPECT_SAYS(caps_text(two), "num_tensors=(int)2, dimensions=(string)\"1:1\\,2:1\"");
  auto rate = harness("", caps("rate"));
  converted(rate, {1});
  EXPECT_SAYS(caps_text(rate), "framerate=(fraction)7/1");
}

TEST(SubPluginConverter, CanWriteHeaders) {
  auto h = harness("", caps("flexible"));
  EXPECT_EQ(content(converted(h, {1, 2, 3}).get()), (Bytes{1, 2, 3}));
  EXPECT_SAYS(caps_text(h), "format=(string)static");
  const Harness flexible{
      gst_harness_new_parse("tensor_converter ! capsfilter caps=other/tensors,format=flexible")};
  gst_harness_set_src_caps_str(flexible.get(), caps("flexible").c_str());
  const auto out = converted(flexible, {1, 2, 3});
  EXPECT_EQ(gst_buffer_get_size(out.get()), 128u + 3u) << "one header, not two";
  EXPECT_NE(message("cut"), "");
}

TEST(SubPluginConverter, CanOmitWhatDownstreamCapsFix) {
  harness("", caps());
  const Harness h{gst_harness_new_parse(
      "tensor_converter ! capsfilter "
      "caps=other/tensors,num_tensors=1,dimensions=(string)3:1,types=(string)uint8,"
      "framerate=10/1,format=static")};
  gst_harness_set_src_caps_str(h.get(), caps().c_str());
  EXPECT_EQ(content(converted(h, {7, 8, 9}).get()), (Bytes{7, 8, 9}));
}

TEST(SubPluginConverter, RejectsAStreamWithAMessage) {
  EXPECT_SAYS(caps_error("", caps("refuse")), "WEIR-2002: the converter bytes rejects this stream");
  EXPECT_SAYS(caps_error("", caps("refuse")), "offered: x-test/bytes");
  EXPECT_SAYS(caps_error("", caps("first-dims")),
              "WEIR-5003: the converter bytes returned invalid tensors");
}

TEST(SubPluginConverter, HasItsFramesCombined) {
  auto h = harness("frames-per-tensor=2", caps());
  EXPECT_SAYS(caps_text(h), "dimensions=(string)4:2, types=(string)uint8");
  for (const Bytes& frame_bytes : {Bytes{1, 2, 3}, Bytes{4, 5, 6}})
    EXPECT_EQ(get_error(h, frame(frame_bytes, 5)), "");
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5u);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:2, types=(string)uint8");
  EXPECT_EQ(get_error(h, frame({7, 8, 9}, 9)), "");
  EXPECT_EQ(stat(h, "held"), 1u);
  EXPECT_EQ(get_error(h, frame({7}, 10)), "");
  EXPECT_EQ(stat(h, "dropped-flush"), 1u) << "frames of another kind start a new tensor";
}

TEST(SubPluginConverter, CannotHaveAllFramesCombined) {
  auto two = harness("frames-per-tensor=2", caps("two"));
  EXPECT_SAYS(get_error(two, frame({1, 2, 3})),
              "WEIR-1004: frames with several tensors cannot be combined into one output\n"
              "  offered: 2 tensors, frames-per-tensor=2");
  auto flexible = harness("frames-per-tensor=2", caps("flexible"));
  EXPECT_SAYS(get_error(flexible, frame({1, 2, 3})),
              "WEIR-1004: the converter bytes outputs flexible tensors, which cannot be combined "
              "into one output\n"
              "  offered: frames-per-tensor=2");
}

TEST(SubPluginConverter, IsValidated) {
  EXPECT_SAYS(message("null"), "WEIR-5003: the converter bytes returned nothing for a frame");
  EXPECT_SAYS(message("no-buffer"),
              "WEIR-5003: the converter bytes returned no GstBuffer for a frame");
  const std::string nonsense = "WEIR-5003: the converter bytes returned invalid tensors\n";
  EXPECT_SAYS(message("count"), nonsense + "  offered: 300 tensors\n  needed: 1 to 256");
  EXPECT_SAYS(message("none"), nonsense + "  offered: 0 tensors");
  EXPECT_SAYS(message("extra"), nonsense + "  offered: 20 tensors, `extra` is NULL");
  EXPECT_SAYS(message("type"), nonsense + "  offered: tensor 0: type 77");
  EXPECT_SAYS(message("dims"), nonsense + "  offered: tensor 0: dimensions ");
  EXPECT_SAYS(message("format"), nonsense + "  offered: format 9");
  EXPECT_SAYS(message("size"),
              "WEIR-2004: the converter bytes returned a frame whose size differs from its "
              "declared size\n  "
              "offered: 3 bytes\n  needed: 4 bytes for 1 tensor: uint8 4:1");
}

TEST(SubPluginConverter, MustAgreeWithTheUser) {
  harness("", caps());
  auto h = harness("input-dim=2 input-type=uint8", caps());
  EXPECT_EQ(content(converted(h, {1, 2}).get()), (Bytes{1, 2}));
  EXPECT_SAYS(get_error(h, frame({1, 2, 3})), "WEIR-2001: a frame does not match input-dim");
}

TEST(SubPluginConverter, IsReportedWhenItsFileIsRejected) {
  const auto find = WEIR_LIBRARY(nnstreamer_converter_find);
  ASSERT_NE(find("bytes"), nullptr);
  for (const char* name : {"lacking", "absent", "twice", "any"}) EXPECT_EQ(find(name), nullptr);
  auto h = harness("", caps());
  EXPECT_EQ(accepted(h, "x-test/capless"), "EMPTY") << "its query_caps returned NULL";
}

TEST(SubPluginConverter, IsSelectedByItsName) {
  static NNStreamerExternalConverter named{};
  named = *WEIR_LIBRARY(nnstreamer_converter_find)("bytes");
  named.name = "x-test/by-name";
  ASSERT_TRUE(WEIR_LIBRARY(registerExternalConverter)(&named));
  const auto element = lone_element("tensor_converter");
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  auto given = Ref<GstCaps>::adopt(gst_caps_from_string("x-test/by-name,framerate=1/1"));
  EXPECT_TRUE(gst_pad_send_event(pad.get(), gst_event_new_caps(given.get())));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  WEIR_LIBRARY(unregisterExternalConverter)("x-test/by-name");
}

// As without Weir's own python3.
TEST(SubPluginConverter, RunsScriptsByItsOpen) {
  const std::string modules = std::getenv("WEIR_MODULE_PATH");
  setenv("WEIR_MODULE_PATH", "/nowhere", 1);
  auto h = harness("mode=custom-script:/a/script.py", "application/octet-stream,framerate=10/1");
  EXPECT_EQ(content(converted(h, {1, 2}).get()), (Bytes{1, 2}));
  EXPECT_SAYS(caps_error("mode=custom-script:/a/missing.py", "application/octet-stream"),
              "WEIR-5003: the converter python3 cannot open the script\n  offered: /a/missing.py: "
              "open returned -2");
  setenv("WEIR_MODULE_PATH", modules.c_str(), 1);
}

// A program may unregister its converter, and free its memory, while a pipeline uses it.
TEST(SubPluginConverter, ContinuesAfterItWasUnregistered) {
  auto own = std::make_unique<NNStreamerExternalConverter>(
      *WEIR_LIBRARY(nnstreamer_converter_find)("bytes"));
  own->name = "x-test/short-lived";
  ASSERT_TRUE(WEIR_LIBRARY(registerExternalConverter)(own.get()));
  auto h = harness("", caps("", "short-lived"));
  EXPECT_EQ(content(converted(h, {1, 2}).get()), (Bytes{1, 2}));
  WEIR_LIBRARY(unregisterExternalConverter)("x-test/short-lived");
  *own = {};
  own.reset();
  EXPECT_EQ(content(converted(h, {3, 4}).get()), (Bytes{3, 4}));
}

GstBuffer* throwing(GstBuffer*, GstTensorsConfig*, void*) {
  throw std::runtime_error("out of convert");
}
gboolean throwing_config(const GstCaps*, GstTensorsConfig*) {
  throw std::runtime_error("out of get_out_config");
}
GstCaps* throwing_caps(const GstTensorsConfig*) {
  throw 42;
}

TEST(SubPluginConverter, ReportsAnExceptionWithItsName) {
  const auto add = WEIR_LIBRARY(registerExternalConverter);
  auto own = *WEIR_LIBRARY(nnstreamer_converter_find)("bytes");
  own.name = "x-test/throwing";
  own.convert = throwing;
  ASSERT_TRUE(add(&own));
  {
    auto h = harness("", caps("", "throwing"));
    const auto text = get_error(h, frame({1}));
    EXPECT_SAYS(text, "WEIR-5003: the converter x-test/throwing threw an exception");
    EXPECT_SAYS(text, "offered: out of convert");
    EXPECT_EQ(stat(h, "dropped-error"), 1u);
    EXPECT_EQ(stat(h, "held"), 0u);
  }
  own.get_out_config = throwing_config;
  EXPECT_SAYS(caps_error("", caps("", "throwing")), "offered: out of get_out_config");
  own.query_caps = throwing_caps;
  EXPECT_EQ(accepted(harness("", video("RGB", 4, 1)), "x-test/none"), "EMPTY");
  WEIR_LIBRARY(unregisterExternalConverter)(own.name);
}

TEST(ConverterFunction, ReportsAnExceptionWithItsName) {
  const auto function = [](GstBuffer* in, void*, GstTensorsConfig* config) {
    return throwing(in, config, nullptr);
  };
  ASSERT_EQ(WEIR_LIBRARY(nnstreamer_converter_custom_register)("throwing", function, nullptr), 0);
  auto h = harness("mode=custom-code:throwing", video("GRAY8", 4, 1));
  EXPECT_SAYS(get_error(h, frame({1, 2, 3, 4})),
              "WEIR-5003: the function throwing threw an exception\n  offered: out of convert");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  EXPECT_EQ(WEIR_LIBRARY(nnstreamer_converter_custom_unregister)("throwing"), 0);
}

// The buffer's bytes twice, as a tensor of two rows; no buffer for a first byte of 255.
GstBuffer* twice(GstBuffer* in, void* data, GstTensorsConfig* config) {
  ++*static_cast<int*>(data);
  const Bytes bytes = content(in);
  if (bytes[0] == 255) return nullptr;
  config->info.num_tensors = 1;
  config->info.info[0].type = _NNS_UINT8;
  config->info.info[0].dimension[0] = static_cast<uint32_t>(bytes.size());
  config->info.info[0].dimension[1] = 2;
  return gst_buffer_append(gst_buffer_copy(in), gst_buffer_copy(in));
}

TEST(ConverterFunction, OfTheProgramConvertsAnyMedium) {
  int frames = 0;
  const auto add = WEIR_LIBRARY(nnstreamer_converter_custom_register);
  ASSERT_EQ(add("twice", twice, &frames), 0);
  EXPECT_EQ(add("twice", twice, &frames), -EINVAL);
  EXPECT_EQ(add("any", twice, &frames), -EINVAL);
  for (const std::string& medium : {std::string("application/octet-stream,framerate=10/1"),
                                    video("GRAY8", 3, 1), std::string("x-test/own")}) {
    auto h = harness("mode=custom-code:twice", medium);
    EXPECT_SAYS(caps_text(h), "dimensions=(string)1:1:1:1, types=(string)uint8");
    EXPECT_EQ(content(converted(h, {1, 2, 3}).get()), (Bytes{1, 2, 3, 1, 2, 3}));
    EXPECT_SAYS(caps_text(h), "dimensions=(string)3:2");
    EXPECT_SAYS(get_error(h, frame({255})),
                "WEIR-5003: the function twice returned nothing for a frame");
  }
  EXPECT_EQ(frames, 6);
  auto gathered = harness("mode=custom-code:twice frames-per-tensor=2", video("GRAY8", 3, 1));
  EXPECT_EQ(get_error(gathered, frame({1, 2, 3})), "");
  EXPECT_EQ(content(converted(gathered, {4, 5, 6}).get()),
            (Bytes{1, 2, 3, 1, 2, 3, 4, 5, 6, 4, 5, 6}));
  EXPECT_SAYS(caps_text(gathered), "dimensions=(string)3:2:2");
  EXPECT_EQ(WEIR_LIBRARY(nnstreamer_converter_custom_unregister)("twice"), 0);
  EXPECT_EQ(WEIR_LIBRARY(nnstreamer_converter_custom_unregister)("twice"), -EINVAL);
  auto gone = harness("mode=custom-code:twice", "application/octet-stream,framerate=10/1");
  EXPECT_SAYS(get_error(gone, frame({1})), "WEIR-3011: no function is registered under this name");
}

}  // namespace sub_plugin_converters_test
}  // namespace weir::testing_tensor_converter
