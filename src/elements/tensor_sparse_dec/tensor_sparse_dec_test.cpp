// tensor_sparse_dec in a harness: round trips, caps, invalid headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <random>

#include "core/tensor/sparse.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"

namespace tensor_sparse_dec_test {

using namespace weir::test;

constexpr char kDec[] = "tensor_sparse_dec", kBoth[] = "tensor_sparse_enc ! tensor_sparse_dec",
               kSparse[] = "other/tensors,format=sparse,framerate=30/1";

Bytes chunk(const Bytes& dense, const std::string& dims) {
  const auto out = weir::to_sparse({weir::ElementType::UInt8, weir::Shape::parse(dims), ""},
                                   std::as_bytes(std::span(dense)));
  const auto* data = reinterpret_cast<const uint8_t*>(out->data());
  return {data, data + out->size()};
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
GstFlowReturn push(const Harness& h, const Bytes& bytes) {
  return gst_harness_push(h.get(), frame(bytes));
}

TEST(TensorSparseDec, RestoresEveryTypeRankAndNumberOfTensors) {
  std::mt19937 random(3);
  const char* types[] = {"int32", "uint32",  "int16",   "uint16", "int8",   "uint8",
                         "int64", "float64", "float32", "uint64", "float16"};
  const size_t sizes[] = {4, 4, 2, 2, 1, 1, 8, 8, 4, 8, 2};
  for (size_t count = 1; count <= 20; ++count) {
    std::string type_list, dims;
    Bytes all;
    for (size_t i = 0; i < count; ++i) {
      const size_t kind = (count + i) % std::size(types);
      type_list += (i ? "," : "") + std::string(types[kind]);
      std::string shape = std::to_string(i + 2);  // rank 1 to 16, one dimension above 1
      for (size_t rank = 1; rank <= (count + 3 * i) % 16; ++rank) shape += ":1";
      dims += (i ? "," : "") + shape;
      for (size_t k = 0; k < (i + 2) * sizes[kind]; ++k)
        all.push_back(random() % 3 ? 0 : static_cast<uint8_t>(1 + random() % 100));
    }
    auto h = make_harness(kBoth, tensors(type_list, dims));
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(all, 5, 6)));
    ASSERT_TRUE(out) << count;
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 6u);
    size_t header_at = 0;  // offset of the packed header, before tensor 15
    for (guint i = 0; i < std::min<size_t>(count, 15); ++i)
      header_at += gst_memory_get_sizes(gst_buffer_peek_memory(out.get(), i), nullptr, nullptr);
    Bytes got = content(out.get());
    const auto header = got.begin() + static_cast<std::ptrdiff_t>(header_at);
    if (count > 16) got.erase(header, header + 19224);
    EXPECT_EQ(got, all) << count;
    auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
    const GstStructure* structure = gst_caps_get_structure(caps.get(), 0);
    EXPECT_EQ(gst_structure_get_string(structure, "types"), type_list);
    EXPECT_EQ(gst_structure_get_string(structure, "dimensions"), dims);
    EXPECT_EQ(stat(h, kDec, "consumed"), 1u);
  }
}

TEST(TensorSparseDec, FindsSeveralTensorsInOneMemory) {
  auto h = make_harness(kDec, kSparse);
  const Bytes one{0, 3, 0}, two{9, 0};
  ASSERT_EQ(push(h, chunk(one, "3:1") + chunk(two, "2")), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(content(out.get()), one + two);
  EXPECT_SAYS(caps_text(h), "num_tensors=(int)2, dimensions=(string)\"3:1\\,2\"");
}

TEST(TensorSparseDec, KeepsTheClient) {
  auto h = make_harness(kDec, kSparse);
  GstBuffer* in = frame(chunk({1}, "1"));
  ASSERT_TRUE(weir::gst::set_client(in, 42));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(weir::gst::get_client_id(out.get()), 42);
}

TEST(TensorSparseDec, SendsCapsBeforeLaterEvents) {
  auto h = make_harness(kDec, kSparse);
  gst_harness_push_event(h.get(), gst_event_new_tag(gst_tag_list_new_empty()));
  ASSERT_EQ(push(h, chunk({1}, "1")), GST_FLOW_OK);
  std::vector<std::string> order;
  while (GstEvent* event = gst_harness_try_pull_event(h.get())) {
    order.emplace_back(GST_EVENT_TYPE_NAME(event));
    gst_event_unref(event);
  }
  EXPECT_EQ(order, (std::vector<std::string>{"stream-start", "caps", "segment", "tag"}));
}

// Of many events before the first frame, the newest of each type are kept, in order.
TEST(TensorSparseDec, KeepsABoundedNumberOfEventsUntilItSendsCaps) {
  auto h = make_harness(kDec, kSparse);
  gst_harness_push_event(h.get(), gst_event_new_tag(gst_tag_list_new_empty()));
  constexpr GstClockTime kGaps = 1000;
  for (GstClockTime i = 0; i < kGaps; ++i) gst_harness_push_event(h.get(), gst_event_new_gap(i, 1));
  ASSERT_EQ(push(h, chunk({1}, "1")), GST_FLOW_OK);
  std::vector<std::string> others;
  std::vector<GstClockTime> gaps;
  while (auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get()))) {
    GstClockTime start = 0;
    if (GST_EVENT_TYPE(event.get()) != GST_EVENT_GAP) {
      others.emplace_back(GST_EVENT_TYPE_NAME(event.get()));
      continue;
    }
    gst_event_parse_gap(event.get(), &start, nullptr);
    gaps.push_back(start);
  }
  EXPECT_EQ(others, (std::vector<std::string>{"stream-start", "caps", "segment", "tag"}));
  EXPECT_LE(gaps.size(), 100u);
  ASSERT_FALSE(gaps.empty());
  for (size_t i = 0; i < gaps.size(); ++i) EXPECT_EQ(gaps[i], kGaps - gaps.size() + i);
}

TEST(TensorSparseDec, EndsAStreamWithoutFrames) {
  auto h = make_harness(kDec, kSparse);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  bool ended = false;
  while (GstEvent* event = gst_harness_try_pull_event(h.get())) {
    ended = ended || GST_EVENT_TYPE(event) == GST_EVENT_EOS;
    gst_event_unref(event);
  }
  EXPECT_TRUE(ended);
}

TEST(TensorSparseDec, SendsNewCapsWhenTheTensorsChange) {
  auto h = make_harness(kDec, kSparse);
  ASSERT_EQ(push(h, chunk({1, 0}, "2")), GST_FLOW_OK);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2,");
  ASSERT_EQ(push(h, chunk({0, 0, 4}, "3")), GST_FLOW_OK);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3,");
  gst_buffer_unref(gst_harness_pull(h.get()));
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{0, 0, 4}));
}

TEST(TensorSparseDec, ChecksFramesAgainstFixedDownstreamCaps) {
  auto h = make_harness(kDec);
  Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), tensors("uint8", "2:1:1:1", "10/1").c_str());
  gst_harness_set_src_caps_str(h.get(), kSparse);
  ASSERT_EQ(push(h, chunk({1, 0}, "2")), GST_FLOW_OK) << "2 and 2:1:1:1 are equal";
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  EXPECT_EQ(push(h, chunk({1, 0, 0}, "3")), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "WEIR-2001: the tensors of a sparse frame do not match the caps");
  EXPECT_SAYS(error, "offered: 1 tensor: uint8 3\n  needed: 1 tensor: uint8 2:1:1:1");
  EXPECT_SAYS(error, "first difference: tensor 0: dimension is 3, needed is 2:1:1:1");
  EXPECT_SAYS(error, "dimensions=(string)\"3\"");
  EXPECT_EQ(stat(h, kDec, "dropped-error"), 1u);
  EXPECT_EQ(stat(h, kDec, "consumed"), 1u);
}

// Changes one 32-bit word of a valid chunk: each fault has its own error text.
TEST(TensorSparseDec, ReportsInvalidHeaders) {
  const struct {
    size_t at;
    uint32_t value;
    const char* message;
  } headers[] = {{0, 0, "does not start with a tensor header"},
                 {4, 0, "unknown version"},
                 {8, 11, "unknown element type"},
                 {12, 0, "bad dimensions"},
                 {12, 1, "more values than the tensor has elements"},
                 {76, 3, "unknown format"},
                 {76, 0, "too short for a tensor header"},
                 {84, 3, "declares more bytes than its memory holds"},
                 {84, 0xFFFFFFFF, "more values than the tensor has elements"},
                 {134, 9, "a sparse tensor has a bad index"},
                 {134, 1, "a sparse tensor has a bad index"}};
  for (const auto& header : headers) {
    auto h = make_harness(kDec, kSparse);
    Errors errors(h);
    Bytes bytes = chunk({0, 7, 0, 9, 0}, "5");
    std::memcpy(bytes.data() + header.at, &header.value, 4);
    EXPECT_EQ(push(h, bytes), GST_FLOW_ERROR) << header.message;
    const std::string error = errors.next();
    EXPECT_SAYS(error, "WEIR-2005");
    EXPECT_SAYS(error, header.message);
    EXPECT_EQ(stat(h, kDec, "dropped-error"), 1u);
  }
}

TEST(TensorSparseDec, RejectsTensorsThatAreNotSparse) {
  auto h = make_harness(kDec, kSparse);
  Errors errors(h);
  Bytes bytes = chunk({0, 0, 0, 0, 0}, "5");
  bytes[76] = 1;  // flexible
  EXPECT_EQ(push(h, bytes + Bytes(5)), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2005: a tensor is not sparse\n  offered: flexible");
}

TEST(TensorSparseDec, RejectsTruncatedMemory) {
  const Bytes whole = chunk({0, 7, 0, 9, 0}, "5");
  for (size_t size = 1; size < whole.size(); size += 13) {
    auto h = make_harness(kDec, kSparse);
    Errors errors(h);
    EXPECT_EQ(push(h, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))),
              GST_FLOW_ERROR);
    EXPECT_SAYS(errors.next(), "WEIR-2005");
  }
}

TEST(TensorSparseDec, RejectsABufferBeforeCaps) {
  EXPECT_SAYS(error_before_caps(kDec), "WEIR-2003: a buffer arrived before caps");
}

}  // namespace tensor_sparse_dec_test
