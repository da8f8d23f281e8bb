// tensor_sparse_enc in a harness: output compared byte by byte, caps, errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"

namespace tensor_sparse_enc_test {

using namespace weir::test;

constexpr char kEnc[] = "tensor_sparse_enc";

// docs/compatibility/types-and-caps.md 1.7 and 1.8 in the simplest code, for uint8.
Bytes chunk(const Bytes& dense, const std::vector<uint32_t>& dims) {
  std::vector<uint32_t> words(32), indices;
  Bytes nonzero;
  for (uint32_t i = 0; i < dense.size(); ++i) {
    if (dense[i] == 0) continue;
    nonzero.push_back(dense[i]);
    indices.push_back(i);
  }
  words[0] = 0xfeedcced;
  words[1] = 0xDE001000;
  words[2] = 5;  // uint8
  std::copy(dims.begin(), dims.end(), words.begin() + 3);
  words[19] = 2;  // sparse
  words[20] = 4;  // tensor
  words[21] = static_cast<uint32_t>(nonzero.size());
  Bytes out(128);
  std::memcpy(out.data(), words.data(), 128);
  out.insert(out.end(), nonzero.begin(), nonzero.end());
  out.resize(out.size() + 4 * indices.size());
  if (!indices.empty())
    std::memcpy(out.data() + out.size() - 4 * indices.size(), indices.data(), 4 * indices.size());
  return out;
}
Bytes memory(GstBuffer* buffer, guint index) {
  const weir::gst::MappedMemory map(gst_buffer_peek_memory(buffer, index), GST_MAP_READ);
  const auto* data = reinterpret_cast<const uint8_t*>(map.bytes().data());
  return {data, data + map.bytes().size()};
}

TEST(TensorSparseEnc, WritesHeaderValuesAndIndices) {
  auto h = make_harness(kEnc, tensors("uint8", "3:2:1"));
  const Bytes dense{0, 7, 0, 0, 0, 255};
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(dense, 11, 22)));
  EXPECT_EQ(content(out.get()), chunk(dense, {3, 2, 1}));
  EXPECT_EQ(gst_buffer_get_size(out.get()), 128u + 2 + 8);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 11u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 22u);
  EXPECT_EQ(caps_text(h), "other/tensors, format=(string)sparse, framerate=(fraction)30/1");
  EXPECT_EQ(stat(h, kEnc, "consumed"), 1u);
  EXPECT_EQ(stat(h, kEnc, "pushed"), 1u);
}

TEST(TensorSparseEnc, KeepsTheClient) {
  auto h = make_harness(kEnc, tensors("uint8", "1"));
  GstBuffer* in = frame(Bytes{1});
  ASSERT_TRUE(weir::gst::set_client(in, 42));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(weir::gst::get_client_id(out.get()), 42);
}

// 1 to 20 tensors of different sizes: of more than 16, the 16th and later ones are packed.
TEST(TensorSparseEnc, AcceptsOneToTwentyTensors) {
  for (size_t count = 1; count <= 20; ++count) {
    std::string types, dims;
    Bytes all;
    std::vector<Bytes> expected;
    for (size_t i = 0; i < count; ++i) {
      types += i ? ",uint8" : "uint8";
      dims += (i ? "," : "") + std::to_string(i + 1);
      Bytes dense(i + 1);
      for (size_t k = 0; k <= i; k += 2) dense[k] = static_cast<uint8_t>(i + k + 1);
      all.insert(all.end(), dense.begin(), dense.end());
      expected.push_back(chunk(dense, {static_cast<uint32_t>(i + 1)}));
    }
    auto h = make_harness(kEnc, tensors(types, dims));
    // All in one memory, split by the caps.
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(all)));
    ASSERT_TRUE(out) << count;
    ASSERT_EQ(gst_buffer_n_memory(out.get()), std::min<size_t>(count, 16)) << count;
    const size_t alone = count > 16 ? 15 : count;
    for (size_t i = 0; i < alone; ++i)
      EXPECT_EQ(memory(out.get(), static_cast<guint>(i)), expected[i]) << count << " " << i;
    if (alone == count) continue;
    const Bytes packed = memory(out.get(), 15);
    Bytes rest;
    for (size_t i = alone; i < count; ++i)
      rest.insert(rest.end(), expected[i].begin(), expected[i].end());
    EXPECT_EQ(Bytes(packed.begin() + 19224, packed.end()), rest) << count;
    EXPECT_EQ(packed[8], count - 16);
  }
}

TEST(TensorSparseEnc, UsesTheRateThatDownstreamFixes) {
  auto h = make_harness(kEnc);
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=sparse,framerate=5/1");
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2").c_str());
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(2))));
  EXPECT_EQ(caps_text(h), "other/tensors, format=(string)sparse, framerate=(fraction)5/1");
}

TEST(TensorSparseEnc, FollowsChangedCaps) {
  auto h = make_harness(kEnc, tensors("uint8", "2"));
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(2))));
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "4").c_str());
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes{0, 0, 0, 1})));
  EXPECT_EQ(content(out.get()), chunk({0, 0, 0, 1}, {4}));
}

TEST(TensorSparseEnc, RejectsAFrameOfTheWrongSize) {
  auto h = make_harness(kEnc, tensors("uint8", "4"));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(3))), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "WEIR-2004");
  EXPECT_SAYS(error, "3 bytes");
  EXPECT_EQ(stat(h, kEnc, "dropped-error"), 1u);
  EXPECT_EQ(stat(h, kEnc, "held"), 0u);
}

TEST(TensorSparseEnc, ReportsADownstreamThatRejectsSparseTensors) {
  auto h = make_harness(kEnc);
  Errors errors(h);
  gst_harness_set_sink_caps_str(h.get(), tensors("uint8", "4").c_str());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "4").c_str());
  const std::string error = errors.next();
  EXPECT_SAYS(error,
              "WEIR-2001: the element downstream of tensor_sparse_enc does not accept its output");
  EXPECT_SAYS(error, "offered: sparse tensors\n  needed: other/tensors, format=(string)static");
}

TEST(TensorSparseEnc, RejectsABufferBeforeCaps) {
  EXPECT_SAYS(error_before_caps(kEnc), "WEIR-2003: a buffer arrived before caps");
}

}  // namespace tensor_sparse_enc_test
