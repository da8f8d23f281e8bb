// tensor_converter with flexible tensors: headers are stripped, and their contents are validated.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_converter/converter_test_support.hpp"

namespace flexible_test {

using namespace weir;
using namespace weir::testing_tensor_converter;

constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=10/1";

Bytes tensor(const TensorSpec& spec, const Bytes& payload, Format format = Format::Static) {
  TensorHeader header{spec, format, MediaType::Tensor, 0};
  Bytes out(kTensorHeaderBytes + payload.size());
  write_tensor_header(header, std::as_writable_bytes(std::span(out)).first<kTensorHeaderBytes>());
  std::copy(payload.begin(), payload.end(), out.begin() + kTensorHeaderBytes);
  return out;
}
TensorSpec make_byte_spec(uint32_t count) {
  return {ElementType::UInt8, Shape{count}, ""};
}
Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

TEST(ConverterFlexible, LosesItsHeaderWithoutACopy) {
  auto h = harness("", kFlexible);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1, types=(string)uint8");
  const Bytes payload = ramp(12);
  for (const auto format : {Format::Static, Format::Flexible}) {
    const TensorSpec spec{ElementType::Float32, Shape{3, 1}, ""};
    auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame(tensor(spec, payload, format))));
    EXPECT_EQ(content(out.get()), payload);
    EXPECT_SAYS(caps_text(h), "dimensions=(string)3:1, types=(string)float32");
    EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  }
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(ConverterFlexible, ChangesItsCapsWheneverTheTensorsChangeAndOnlyThen) {
  auto h = harness("", kFlexible);
  const auto sizes = {2u, 2u, 3u, 2u};
  int changes = 0;
  for (const auto size : sizes) {
    auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame(tensor(make_byte_spec(size), ramp(size)))));
    EXPECT_EQ(content(out.get()), ramp(size));
    EXPECT_SAYS(caps_text(h), "dimensions=(string)" + std::to_string(size) + ",");
  }
  while (GstEvent* raw = gst_harness_try_pull_event(h.get())) {
    const auto event = Ref<GstEvent>::adopt(raw);
    changes += GST_EVENT_TYPE(raw) == GST_EVENT_CAPS;
  }
  EXPECT_EQ(changes, 4) << "the placeholder, 2, 3, 2";
}

TEST(ConverterFlexible, KeepsItsCapsWhenPropertiesChange) {
  auto h = harness("", kFlexible);
  const auto converter = find_element(h, "tensor_converter");
  const auto push = [&] {
    gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(tensor(make_byte_spec(2), ramp(2)))));
  };
  push();
  g_object_set(converter.get(), "silent", FALSE, nullptr);
  push();
  g_object_set(converter.get(), "set-timestamp", FALSE, nullptr);
  push();
  int changes = 0;
  while (GstEvent* raw = gst_harness_try_pull_event(h.get())) {
    const auto event = Ref<GstEvent>::adopt(raw);
    changes += GST_EVENT_TYPE(raw) == GST_EVENT_CAPS;
  }
  EXPECT_EQ(changes, 2) << "the placeholder, 2";
}

TEST(ConverterFlexible, MayHaveSeveralTensorsInOneMemoryOrInTheirOwn) {
  const Bytes a = tensor(make_byte_spec(2), {1, 2});
  const Bytes b = tensor({ElementType::Int16, Shape{2}, ""}, {3, 4, 5, 6});
  for (const bool together : {true, false}) {
    auto h = harness("", kFlexible);
    GstBuffer* in = together ? frame(joined({a, b})) : gst_buffer_append(frame(a), frame(b));
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    ASSERT_TRUE(out);
    EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
    EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6}));
    EXPECT_SAYS(caps_text(h), "num_tensors=(int)2, dimensions=(string)\"2\\,2\"");
    EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  }
}

// Tensors 0 to 14 in their own memories, 15 to 17 after the packed header.
TEST(ConverterFlexible, MayHaveMoreTensorsThanMemories) {
  auto h = harness("", kFlexible);
  GstBuffer* in = gst_buffer_new();
  Bytes expected;
  for (uint8_t i = 0; i < 15; ++i) {
    in = gst_buffer_append(in, frame(tensor(make_byte_spec(1), {i})));
    expected.push_back(i);
  }
  Bytes packed(kPackedHeaderBytes);
  std::vector<TensorSpec> specs;
  for (uint8_t i = 15; i < 18; ++i) {
    const Bytes chunk = tensor(make_byte_spec(2), {i, i});
    packed.insert(packed.end(), chunk.begin(), chunk.end());
    expected.insert(expected.end(), 2, i);
    specs.push_back(make_byte_spec(2));
  }
  write_packed_header(specs, std::vector<uint64_t>(3, kTensorHeaderBytes + 2),
                      std::as_writable_bytes(std::span(packed)).first<kPackedHeaderBytes>());
  auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), gst_buffer_append(in, frame(packed))));
  ASSERT_TRUE(out);
  EXPECT_EQ(content(out.get()), expected);
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)18");
}

TEST(ConverterFlexible, MustHaveTheSizeOfItsHeader) {
  const Bytes good = tensor(make_byte_spec(8), ramp(8));
  auto h = harness("", kFlexible);
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(get_error(h, frame(Bytes(good.begin(), good.begin() + long(size)))), "") << size;
  EXPECT_SAYS(get_error(h, frame(Bytes(good.begin(), good.end() - 1))),
              "WEIR-2005: a tensor header declares more bytes than its memory holds");
  EXPECT_SAYS(get_error(h, frame(joined({good, {1}}))), "WEIR-2005");
  // The parser allows bytes after a tensor in its own memory; the converter does not.
  EXPECT_SAYS(get_error(h, gst_buffer_append(frame(joined({good, {1}})), frame(good))),
              "WEIR-2004: a frame has bytes after its last tensor");
  EXPECT_EQ(stat(h, "dropped-error"), good.size() + 3);
  EXPECT_EQ(stat(h, "pushed"), 0u);
}

TEST(ConverterFlexible, WithADamagedHeaderIsRefused) {
  const Bytes good = tensor(make_byte_spec(8), ramp(8));
  auto h = harness("", kFlexible);
  for (const size_t word : {0, 1, 2, 19, 20}) {
    Bytes bad = good;
    const uint32_t value = 0x7FFFFFFF;
    std::memcpy(bad.data() + 4 * word, &value, 4);
    EXPECT_SAYS(get_error(h, frame(bad)), "WEIR-2005") << word;
  }
  // A false size: 2^31 x 2^31 x 2^31 elements.
  EXPECT_SAYS(
      get_error(h, frame(tensor({ElementType::Float64, Shape{1u << 31, 1u << 31, 1u << 31}, ""},
                                ramp(8)))),
      "WEIR-2005: the dimensions of a tensor header overflow");
}

TEST(ConverterFlexible, MustBeDense) {
  auto h = harness("", kFlexible);
  const auto text = get_error(h, frame(tensor(make_byte_spec(8), {}, Format::Sparse)));
  EXPECT_SAYS(text, "WEIR-2002: a tensor of a flexible stream is sparse");
}

TEST(ConverterFlexible, MustMatchTheProperties) {
  auto h = harness("input-dim=2:2 input-type=uint8", kFlexible);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:2, types=(string)uint8");
  EXPECT_EQ(get_error(h, frame(tensor({ElementType::UInt8, Shape{2, 2}, ""}, ramp(4)))), "");
  const auto text = get_error(h, frame(tensor(make_byte_spec(4), ramp(4))));
  EXPECT_SAYS(text, "WEIR-2001: a frame does not match input-dim and input-type");
  EXPECT_SAYS(text, "dimension is 4, needed is 2:2");
  EXPECT_SAYS(text, "fix: remove input-dim and input-type");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(ConverterFlexible, FollowsOtherCapsInTheMiddleOfAStream) {
  auto h = harness("", kFlexible);
  EXPECT_EQ(get_error(h, frame(tensor(make_byte_spec(4), ramp(4)))), "");
  EXPECT_EQ(change_caps(h, video("GRAY8", 4, 1)), "");
  EXPECT_EQ(get_error(h, frame(ramp(4))), "");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1:4:1:1");
  EXPECT_EQ(change_caps(h, "other/tensors,format=flexible,framerate=20/1"), "");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1, types=(string)uint8") << "not what was before";
  EXPECT_EQ(get_error(h, frame(tensor(make_byte_spec(4), ramp(4)))), "");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)20/1");
  EXPECT_SAYS(change_caps(h, "other/tensors,format=sparse,framerate=20/1"),
              "WEIR-2002: these tensors need no tensor_converter");
}

TEST(ConverterFlexible, CannotBeGathered) {
  const auto text = caps_error("frames-per-tensor=2", kFlexible);
  EXPECT_SAYS(text, "WEIR-1004: flexible tensors cannot be combined into one output");
  EXPECT_SAYS(text, "fix: tensor_converter frames-per-tensor=1");
}

TEST(ConverterFlexible, BeginsWithWhatDownstreamRequires) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(
      h.get(), "other/tensor,dimension=(string)4:1,type=(string)uint8,framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), kFlexible);
  EXPECT_SAYS(caps_text(h), "dimension=(string)4:1, type=(string)uint8");
  EXPECT_EQ(get_error(h, frame(tensor(make_byte_spec(4), ramp(4)))), "");
  const auto text = get_error(h, frame(tensor(make_byte_spec(5), ramp(5))));
  EXPECT_SAYS(text,
              "WEIR-2001: the element downstream of tensor_converter does not accept its output");
  EXPECT_SAYS(text, "first difference: tensor 0: dimension is 5, needed is 4:1");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

// A downstream capsfilter that does not fix the type.
class ConverterWaits : public ::testing::Test {
 protected:
  static Harness converter(const std::string& wanted) {
    auto h = make_harness("tensor_converter ! capsfilter caps=\"" + wanted + "\"");
    Errors errors(h);
    gst_harness_set_src_caps_str(h.get(), kFlexible);
    EXPECT_EQ(errors.next(), "");
    return h;
  }
  static std::vector<std::string> events(const Harness& h) {
    std::vector<std::string> out;
    while (GstEvent* raw = gst_harness_try_pull_event(h.get())) {
      const auto event = Ref<GstEvent>::adopt(raw);
      out.emplace_back(GST_EVENT_TYPE_NAME(raw));
    }
    return out;
  }
  const std::string wanted_ = "other/tensor,dimension=(string)3:4:4:1";
  const TensorSpec picture_{ElementType::UInt8, Shape{3, 4, 4}, ""};
};
using Names = std::vector<std::string>;

TEST_F(ConverterWaits, ForTheFirstFrameWhereAPlaceholderIsRefused) {
  const auto h = converter(wanted_);
  Errors errors(h);
  gst_harness_push_event(h.get(), gst_event_new_gap(0, 1));
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(events(h), Names{"stream-start"}) << "no caps and nothing that goes after them";
  for (int i = 0; i < 2; ++i) {
    auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame(tensor(picture_, ramp(48)))));
    EXPECT_EQ(content(out.get()), ramp(48));
  }
  EXPECT_EQ(events(h), (Names{"caps", "segment"}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)3:4:4:1, type=(string)uint8");
  gst_harness_push_event(h.get(), gst_event_new_gap(0, 1));
  EXPECT_EQ(events(h), Names{"gap"});
}

TEST_F(ConverterWaits, DownstreamOfATransformToo) {
  const auto h = make_harness(
      "tensor_converter ! tensor_transform mode=typecast option=float32 ! capsfilter caps=\"" +
      wanted_ + "\"");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFlexible);
  EXPECT_EQ(errors.next(), "");
  EXPECT_EQ(gst_harness_push(h.get(), frame(tensor(picture_, ramp(48)))), GST_FLOW_OK);
  EXPECT_EQ(errors.next(), "");
  EXPECT_SAYS(caps_text(h), "type=(string)float32");
}

TEST_F(ConverterWaits, AndFailsWithAFrameThatIsRefused) {
  for (const uint32_t size : {1u, 5u}) {
    const auto h = converter(wanted_);
    const auto text = get_error(h, frame(tensor(make_byte_spec(size), ramp(size))));
    EXPECT_SAYS(text,
                "WEIR-2001: the element downstream of tensor_converter does not accept its output");
    EXPECT_SAYS(text, "offered: 1 tensor: uint8 " + std::to_string(size));
  }
}

TEST_F(ConverterWaits, NotWhereThePlaceholderIsTaken) {
  const auto h = converter("other/tensor");
  EXPECT_EQ(events(h), (Names{"stream-start", "caps", "segment"}));
}

TEST_F(ConverterWaits, NotIfTheUserSetsTheTensors) {
  const auto h = make_harness("tensor_converter input-dim=5 input-type=uint8 ! capsfilter caps=\"" +
                              wanted_ + "\"");
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), kFlexible);
  EXPECT_SAYS(errors.next(),
              "the element downstream of tensor_converter does not accept its output");
}

TEST_F(ConverterWaits, AndEndsWithoutAFrame) {
  const auto h = converter(wanted_);
  EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_eos()));
  EXPECT_EQ(events(h), (Names{"stream-start", "eos"}));
}

TEST(ConverterFlexible, GetsHeadersAgainWhenDownstreamRequiresThem) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible");
  gst_harness_set_src_caps_str(h.get(), kFlexible);
  for (const uint32_t size : {4u, 5u}) {
    const Bytes in = tensor(make_byte_spec(size), ramp(size));
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
    EXPECT_EQ(content(out.get()), in);
  }
}

TEST(ConverterFlexible, GetsMissingTimeStampsForEachFrame) {
  auto h = harness("", kFlexible);
  for (const uint32_t i : {0u, 1u, 2u}) {
    auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame(tensor(make_byte_spec(i + 1), ramp(i + 1)))));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), i * 100 * GST_MSECOND);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 100 * GST_MSECOND);
  }
}

}  // namespace flexible_test
