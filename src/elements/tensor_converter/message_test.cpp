// tensor_decoder and tensor_converter with the messages of protobuf, flatbuf and flexbuf. Skipped
// for formats that were not built.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/infer/module/module_library.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_converter/converter_test_support.hpp"

namespace message_test {

using namespace weir;
using namespace weir::testing_tensor_converter;

std::string static_caps(const std::string& dimensions, const std::string& types, int count,
                        int rate = 10) {
  return "other/tensors,format=static,num_tensors=" + std::to_string(count) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=" + std::to_string(rate) + "/1";
}
constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=10/1";

// A flexible tensor of uint8 with the header of a picture.
Bytes chunk(const Bytes& payload) {
  Bytes out(kTensorHeaderBytes);
  const TensorHeader header{{ElementType::UInt8, Shape{static_cast<uint32_t>(payload.size())}, ""},
                            Format::Flexible,
                            MediaType::Video,
                            0};
  write_tensor_header(header, std::as_writable_bytes(std::span(out)).first<kTensorHeaderBytes>());
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}

class ConverterMessage : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    static infer::ModuleLibrary library;
    if (!library.decoder(GetParam())) GTEST_SKIP() << "not built";
  }
  static std::string media() {
    return "other/" + GetParam() + (GetParam() == "flexbuf" ? "" : "-tensor");
  }
  // One frame of these memories as a message.
  static GstBuffer* message(const std::string& caps, const std::vector<Bytes>& memories) {
    auto h = make_harness("tensor_decoder mode=" + GetParam(), caps);
    GstBuffer* in = gst_buffer_new();
    for (const auto& memory : memories) in = gst_buffer_append(in, frame(memory));
    return gst_harness_push_and_pull(h.get(), in);
  }
  static Harness converter(const std::string& properties = "") {
    return harness(properties, media() + ",framerate=10/1");
  }
  static Ref<GstBuffer> converted(const Harness& h, GstBuffer* in) {
    return Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  }
};

TEST_P(ConverterMessage, HasTheCapsOfItsFormatAndOneMemory) {
  auto h = make_harness("tensor_decoder mode=" + GetParam(), static_caps("3,2", "uint8,int16", 2));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(
      h.get(), gst_buffer_append(frame(Bytes{1, 2, 3}), frame(Bytes{4, 5, 6, 7}))));
  EXPECT_EQ(caps_text(h), media() + ", framerate=(fraction)10/1");
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 1u);
}

TEST_P(ConverterMessage, RenegotiatesAfterTheFirstBuffer) {
  auto h = converter();
  EXPECT_SAYS(caps_text(h),
              "dimensions=(string)1:1:1:1, types=(string)uint8, framerate=(fraction)10/1");
  auto out = converted(h, message(static_caps("3:2", "uint8", 1), {{1, 2, 3, 4, 5, 6}}));
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)1, dimensions=(string)3:2, types=(string)uint8");
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(stat(h, "bytes-copied"), 0u) << "the tensor is a part of the message";
  out = converted(h, message(static_caps("3,2", "uint8,int16", 2), {{1, 2, 3}, {4, 5, 6, 7}}));
  EXPECT_SAYS(caps_text(h),
              "num_tensors=(int)2, dimensions=(string)\"3\\,2\", types=(string)\"uint8\\,int16\"");
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6, 7}));
}

TEST_P(ConverterMessage, TakesTheFrameRateOfTheMessage) {
  auto h = converter();
  for (const int rate : {10, 25, 0}) {
    converted(h, message(static_caps("1", "uint8", 1, rate), {{1}}));
    EXPECT_SAYS(caps_text(h), "framerate=(fraction)" + std::to_string(rate) + "/1");
  }
}

TEST_P(ConverterMessage, KeepsTheTimeOfTheBuffer) {
  auto h = converter();
  GstBuffer* in = message(static_caps("1", "uint8", 1), {{1}});
  GST_BUFFER_PTS(in) = 7;
  GST_BUFFER_DURATION(in) = 3;
  const auto out = converted(h, in);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
}

TEST_P(ConverterMessage, WaitsForTheFirstBufferWhenThePlaceholderIsRefused) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), static_caps("3", "uint8", 1).c_str());
  gst_harness_set_src_caps_str(h.get(), (media() + ",framerate=10/1").c_str());
  const auto out = converted(h, message(static_caps("3", "uint8", 1), {{1, 2, 3}}));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3}));
}

// Downstream fixes the tensors and the rate of the messages, and the stream has caps of another
// rate.
TEST_P(ConverterMessage, WaitsForTheFirstBufferWhenTheRateIsRefused) {
  for (const char* rate : {"0/1", "10/1"}) {
    Harness h{gst_harness_new_parse("tensor_converter")};
    gst_harness_set_sink_caps_str(h.get(), static_caps("3", "uint8", 1, 25).c_str());
    gst_harness_set_src_caps_str(h.get(), (media() + ",framerate=" + rate).c_str());
    const auto out = converted(h, message(static_caps("3", "uint8", 1, 25), {{1, 2, 3}}));
    EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3})) << rate;
    EXPECT_SAYS(caps_text(h), "framerate=(fraction)25/1");
  }
}

TEST_P(ConverterMessage, MustHaveTheRateThatDownstreamFixes) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), static_caps("3", "uint8", 1, 25).c_str());
  gst_harness_set_src_caps_str(h.get(), (media() + ",framerate=10/1").c_str());
  const auto error = get_error(h, message(static_caps("3", "uint8", 1, 30), {{1, 2, 3}}));
  EXPECT_SAYS(error, "WEIR-2001: the element downstream of tensor_converter does not accept");
  EXPECT_SAYS(error, "framerate=(fraction)25/1");
}

TEST_P(ConverterMessage, MustMatchInputDimAndInputType) {
  auto h = converter("input-dim=2 input-type=uint8");
  const auto error = get_error(h, message(static_caps("3", "uint8", 1), {{1, 2, 3}}));
  EXPECT_SAYS(error, "WEIR-2001: a frame does not match input-dim and input-type");
}

TEST_P(ConverterMessage, KeepsFlexibleTensorsWithTheirHeaders) {
  auto h = converter();
  const Bytes first = chunk({1, 2, 3}), second = chunk({4});
  auto out = converted(h, message(kFlexible, {first, second}));
  EXPECT_EQ(caps_text(h), "other/tensors, format=(string)flexible, framerate=(fraction)10/1");
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
  Bytes both = first;
  both.insert(both.end(), second.begin(), second.end());
  EXPECT_EQ(content(out.get()), both) << "media type and format too";
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  out = converted(h, message(kFlexible, {second}));
  EXPECT_EQ(content(out.get()), second);
  out = converted(h, message(static_caps("3", "uint8", 1), {{1, 2, 3}}));
  EXPECT_SAYS(caps_text(h), "format=(string)static, num_tensors=(int)1, dimensions=(string)3");
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3}));
}

TEST_P(ConverterMessage, GetsHeadersWhenDownstreamRequiresThem) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible");
  gst_harness_set_src_caps_str(h.get(), (media() + ",framerate=10/1").c_str());
  const Bytes out = content(converted(h, message(static_caps("3", "uint8", 1), {{1, 2, 3}})).get());
  const auto header = read_tensor_chunk(std::as_bytes(std::span(out)));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->spec.to_string(), "uint8 3");
  const Bytes flexible = chunk({7, 8});
  EXPECT_EQ(content(converted(h, message(kFlexible, {flexible})).get()), flexible);
}

TEST_P(ConverterMessage, CarriesMoreTensorsThanABufferHasMemories) {
  const std::string pipe =
      "tensor_decoder mode=" + GetParam() + " ! capsfilter caps=" + media() + " ! tensor_converter";
  std::string dimensions = "1", types = "uint8";
  for (int i = 1; i < 40; ++i) dimensions += ",1", types += ",uint8";
  auto h = make_harness(pipe, static_caps(dimensions, types, 40));
  const Bytes bytes = ramp(40);
  EXPECT_EQ(content(Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(bytes))).get()),
            bytes);
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)40");
}

TEST_P(ConverterMessage, CarriesManyFlexibleTensors) {
  auto h = make_harness("tensor_decoder mode=" + GetParam() + " ! capsfilter caps=" + media() +
                            " ! tensor_converter ! capsfilter caps=other/tensors,format=flexible ! "
                            "tensor_decoder mode=octet_stream",
                        kFlexible);
  GstBuffer* in = nullptr;
  {
    std::string dimensions = "1", types = "uint8";
    for (int i = 1; i < 20; ++i) dimensions += ",1", types += ",uint8";
    Harness mux{gst_harness_new_parse(
        ("tensor_converter input-dim=" + dimensions + " input-type=" + types).c_str())};
    gst_harness_set_sink_caps_str(mux.get(), "other/tensors,format=flexible");
    gst_harness_set_src_caps_str(mux.get(), "application/octet-stream,framerate=10/1");
    in = gst_harness_push_and_pull(mux.get(), frame(ramp(20)));
  }
  ASSERT_EQ(gst_buffer_n_memory(in), 16u);
  EXPECT_EQ(content(Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in)).get()), ramp(20));
}

TEST_P(ConverterMessage, GathersStaticTensorsAlone) {
  auto h = converter("frames-per-tensor=2");
  for (const uint8_t value : {1, 2})
    ASSERT_EQ(gst_harness_push(h.get(), message(static_caps("1", "uint8", 1), {{value}})),
              GST_FLOW_OK);
  EXPECT_EQ(content(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())).get()), (Bytes{1, 2}));
  const auto error = get_error(h, message(kFlexible, {chunk({1})}));
  EXPECT_SAYS(error, "WEIR-1004: frames with flexible tensors cannot be combined into one output");
  EXPECT_SAYS(error, "fix: tensor_converter frames-per-tensor=1");
}

TEST_P(ConverterMessage, ThatIsDamagedIsAnErrorAndTheNextGoesOn) {
  auto h = converter();
  const auto good = Ref<GstBuffer>::adopt(message(static_caps("3", "uint8", 1), {{1, 2, 3}}));
  const Bytes bytes = content(good.get());
  const Bytes half(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(bytes.size() / 2));
  for (const Bytes& damaged : {half, Bytes(50, 0xFF), Bytes{1}}) {
    const auto error = get_error(h, frame(damaged));
    EXPECT_SAYS(error, "WEIR-2005: a " + GetParam() + " message is damaged");
    EXPECT_SAYS(error, "tensor_decoder mode=" + GetParam());
  }
  EXPECT_SAYS(get_error(h, gst_buffer_new()), "WEIR-2004: a buffer is empty");
  EXPECT_EQ(stat(h, "dropped-error"), 4u);
  EXPECT_EQ(content(converted(h, gst_buffer_ref(good.get())).get()), (Bytes{1, 2, 3}));
}

TEST_P(ConverterMessage, ThatIsDamagedAtAnyByteEndsNothing) {
  auto h = converter();
  const auto good = Ref<GstBuffer>::adopt(message(kFlexible, {chunk({1, 2, 3})}));
  const Bytes bytes = content(good.get());
  uint64_t refused = 0;
  for (size_t at = 0; at < bytes.size(); ++at) {
    Bytes damaged = bytes;
    damaged[at] ^= 0xFF;
    refused += gst_harness_push(h.get(), frame(damaged)) != GST_FLOW_OK;
    while (GstBuffer* out = gst_harness_try_pull(h.get())) gst_buffer_unref(out);
  }
  EXPECT_EQ(stat(h, "dropped-error"), refused);
  EXPECT_EQ(stat(h, "received"), bytes.size());
  EXPECT_GT(refused, 76u) << "the magic, version, type and dimensions of the header alone";
}

TEST_P(ConverterMessage, LargerThanTheLimitIsNotWritten) {
  auto h = make_harness("tensor_decoder mode=" + GetParam() + " max-buffer-size=64",
                        static_caps("100", "uint8", 1));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(100))), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2006");
}

INSTANTIATE_TEST_SUITE_P(Each, ConverterMessage, testing::Values("protobuf", "flatbuf", "flexbuf"),
                         [](const auto& info) { return info.param; });

}  // namespace message_test
