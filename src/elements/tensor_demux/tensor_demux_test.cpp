// The contents of tensor_demux's output frames, without copies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tests/branches_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace tensor_demux_test {

// Tensor i: int16, i + 1 elements with the values 256 * i, 256 * i + 1, ...; rank 1 to 16.
TensorSpec make_spec(size_t i) {
  TensorSpec spec{ElementType::Int16, {}, ""};
  for (size_t d = 0; d <= i % 16; ++d) spec.shape[d] = 1;
  spec.shape[i % 16] = static_cast<uint32_t>(i + 1);
  return spec;
}
Bytes make_bytes(size_t i) {
  Bytes out;
  for (size_t k = 0; k <= i; ++k) {
    out.push_back(static_cast<uint8_t>(k));
    out.push_back(static_cast<uint8_t>(i));
  }
  return out;
}
std::string make_caps(size_t count) {
  std::vector<TensorSpec> specs;
  for (size_t i = 0; i < count; ++i) specs.push_back(make_spec(i));
  return test::tensors(join_types(specs), join_shapes(specs));
}
Bytes with_header(size_t i) {
  std::array<std::byte, kTensorHeaderBytes> header;
  TensorHeader fields;
  fields.spec = make_spec(i);
  write_tensor_header(fields, header);
  Bytes out;
  for (const std::byte b : header) out.push_back(static_cast<uint8_t>(b));
  const Bytes payload = make_bytes(i);
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}

// A frame of tensors from `first` on; the 16th and later ones in a packed memory.
GstBuffer* frame(size_t count, bool flexible, size_t first = 0) {
  std::vector<Bytes> tensors;
  for (size_t i = first; i < first + count; ++i)
    tensors.push_back(flexible ? with_header(i) : make_bytes(i));
  if (count <= kMemoryLimit) return make_frame(tensors);
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> sizes;
  for (size_t i = kMemoryLimit - 1; i < count; ++i) {
    specs.push_back(make_spec(first + i));
    sizes.push_back(tensors[i].size());
  }
  std::array<std::byte, kPackedHeaderBytes> header;
  write_packed_header(specs, sizes, header);
  Bytes packed;
  for (const std::byte b : header) packed.push_back(static_cast<uint8_t>(b));
  for (size_t i = kMemoryLimit - 1; i < count; ++i)
    packed.insert(packed.end(), tensors[i].begin(), tensors[i].end());
  tensors.resize(kMemoryLimit - 1);
  tensors.push_back(std::move(packed));
  return make_frame(tensors);
}

std::string pad_name(size_t i) {
  return "src_" + std::to_string(i);
}

class TensorDemuxCounts : public ::testing::TestWithParam<std::tuple<size_t, bool>> {};

TEST_P(TensorDemuxCounts, SharesEachTensorOnItsOwnPad) {
  const auto [count, flexible] = GetParam();
  Branches demux("tensor_demux");
  demux.caps(flexible ? kFlexibleBranch : make_caps(count));
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(demux.push(frame(count, flexible)), GST_FLOW_OK);
    for (size_t i = 0; i < count; ++i) {
      const auto out = demux.take(pad_name(i));
      ASSERT_TRUE(out);
      ASSERT_EQ(gst_buffer_n_memory(out.get()), 1u);
      EXPECT_EQ(content(out.get(), 0), flexible ? with_header(i) : make_bytes(i));
    }
  }
  for (size_t i = 0; i < count; ++i) {
    const std::string caps = demux.branch(pad_name(i)).caps();
    if (flexible) {
      EXPECT_SAYS(caps, "other/tensors, format=(string)flexible, framerate=(fraction)30/1");
    } else {
      EXPECT_SAYS(caps, "num_tensors=(int)1, dimensions=(string)" + make_spec(i).shape.to_string());
    }
  }
  EXPECT_EQ(demux.stat("bytes-copied"), 0u);
  EXPECT_EQ(demux.stat("pushed"), 3 * count);
  EXPECT_EQ(demux.stat("pushed-src_0"), 3u);
  EXPECT_EQ(demux.no_more_pads_count(), 1);
  demux.expect_balance();
}
INSTANTIATE_TEST_SUITE_P(Streams, TensorDemuxCounts,
                         ::testing::Combine(::testing::Values(1, 2, 3, 15, 16, 17, 20),
                                            ::testing::Bool()));

TEST(TensorDemux, SharesTheMemories) {
  Branches demux("tensor_demux tensorpick=2,0:1");
  demux.caps(make_caps(3));
  GstBuffer* in = frame(3, false);
  const std::vector<GstMemory*> memories{
      gst_buffer_peek_memory(in, 0), gst_buffer_peek_memory(in, 1), gst_buffer_peek_memory(in, 2)};
  ASSERT_EQ(demux.push(in), GST_FLOW_OK);
  const auto one = demux.take("src_0"), two = demux.take("src_1");
  EXPECT_EQ(gst_buffer_peek_memory(one.get(), 0), memories[2]);
  EXPECT_EQ(gst_buffer_peek_memory(two.get(), 0), memories[0]);
  EXPECT_EQ(gst_buffer_peek_memory(two.get(), 1), memories[1]);
}

TEST(TensorDemux, KeepsTheOrderOfGroups) {
  for (const bool flexible : {false, true}) {
    Branches demux("tensor_demux tensorpick=\"3:1;0+0/2\"");
    demux.caps(flexible ? kFlexibleBranch : make_caps(4));
    ASSERT_EQ(demux.push(frame(4, flexible)), GST_FLOW_OK);
    const std::vector<std::vector<size_t>> groups{{3, 1}, {0, 0}, {2}};
    for (size_t g = 0; g < groups.size(); ++g) {
      const auto out = demux.take(pad_name(g));
      ASSERT_EQ(gst_buffer_n_memory(out.get()), groups[g].size());
      for (size_t i = 0; i < groups[g].size(); ++i)
        EXPECT_EQ(content(out.get(), static_cast<guint>(i)),
                  flexible ? with_header(groups[g][i]) : make_bytes(groups[g][i]));
    }
    if (!flexible) {
      EXPECT_SAYS(demux.branch("src_0").caps(),
                  "num_tensors=(int)2, dimensions=(string)\"1:1:1:4\\,1:2\"");
    }
    EXPECT_EQ(demux.stat("bytes-copied"), 0u);
  }
}

TEST(TensorDemux, CopiesTensorsThatMustBePackedAgain) {
  for (const bool flexible : {false, true}) {
    std::string pick = "19";
    for (int i = 18; i >= 0; --i) pick += ":" + std::to_string(i);
    Branches demux("tensor_demux tensorpick=" + pick);
    demux.caps(flexible ? kFlexibleBranch : make_caps(20));
    ASSERT_EQ(demux.push(frame(20, flexible)), GST_FLOW_OK);
    const auto out = demux.take("src_0");
    ASSERT_EQ(gst_buffer_n_memory(out.get()), 16u);
    const Bytes last = content(out.get(), 15);
    const auto ranges = read_packed_tensors(std::as_bytes(std::span(last)),
                                            flexible ? Format::Flexible : Format::Static);
    ASSERT_TRUE(ranges) << ranges.error().message();
    ASSERT_EQ(ranges->size(), 5u);
    uint64_t packed = 0;
    for (size_t i = 0; i < 5; ++i) {
      const auto [offset, size] = (*ranges)[i];
      const auto at = last.begin() + static_cast<std::ptrdiff_t>(offset);
      EXPECT_EQ(Bytes(at, at + static_cast<std::ptrdiff_t>(size)),
                flexible ? with_header(4 - i) : make_bytes(4 - i));
      packed += size;
    }
    EXPECT_EQ(content(out.get(), 0), flexible ? with_header(19) : make_bytes(19));
    EXPECT_EQ(demux.stat("bytes-copied"), packed);
  }
}

TEST(TensorDemux, SplitsOneMemoryByTheSizesOfTheCaps) {
  Branches demux("tensor_demux");
  demux.caps(make_caps(3));
  Bytes all;
  for (size_t i = 0; i < 3; ++i) {
    const Bytes bytes = make_bytes(i);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  ASSERT_EQ(demux.push(make_frame({all})), GST_FLOW_OK);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(content(demux.take(pad_name(i)).get(), 0), make_bytes(i));
  EXPECT_EQ(demux.stat("bytes-copied"), 0u);
  // Two memories with other boundaries: tensor 1 is in both and must be merged.
  ASSERT_EQ(demux.push(make_frame(
                {Bytes(all.begin(), all.begin() + 4), Bytes(all.begin() + 4, all.end())})),
            GST_FLOW_OK);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(content(demux.take(pad_name(i)).get(), 0), make_bytes(i));
  EXPECT_EQ(demux.stat("bytes-copied"), 4u);
}

TEST(TensorDemux, ReadsConsecutiveChunks) {
  Branches demux("tensor_demux tensorpick=1");
  demux.caps(kFlexibleBranch);
  Bytes all = with_header(0);
  const Bytes second = with_header(1);
  all.insert(all.end(), second.begin(), second.end());
  ASSERT_EQ(demux.push(make_frame({all})), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), second);
  EXPECT_EQ(demux.stat("bytes-copied"), 0u);
}

TEST(TensorDemux, CopiesMemoryThatCannotBeShared) {
  Branches demux("tensor_demux");
  demux.caps(test::tensors("uint8,uint8", "2,2"));
  GstBuffer* in = make_frame({{1, 2}, {3, 4}});
  GST_MINI_OBJECT_FLAG_SET(gst_buffer_peek_memory(in, 1), GST_MEMORY_FLAG_NO_SHARE);
  ASSERT_EQ(demux.push(in), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_1").get(), 0), (Bytes{3, 4}));
  EXPECT_EQ(demux.stat("bytes-copied"), 2u);
}

TEST(TensorDemux, AddsHeadersWhereDownstreamNeedsThem) {
  Branches demux("tensor_demux", {{"src_1", "other/tensors,format=(string)flexible"}});
  demux.caps(make_caps(2));
  ASSERT_EQ(demux.push(frame(2, false)), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), make_bytes(0));
  EXPECT_EQ(content(demux.take("src_1").get(), 0), with_header(1));
  EXPECT_EQ(demux.stat("bytes-copied"), make_bytes(1).size());
}

TEST(TensorDemux, ForwardsMetadata) {
  Branches demux("tensor_demux");
  demux.caps(test::tensors("uint8,uint8", "3:4:2,3:8:6"));
  GstBuffer* in = make_frame({Bytes(24), Bytes(144)});
  GST_BUFFER_PTS(in) = 5;
  GST_BUFFER_DTS(in) = 4;
  GST_BUFFER_DURATION(in) = 3;
  GST_BUFFER_OFFSET(in) = 2;
  GST_BUFFER_FLAG_SET(in, GST_BUFFER_FLAG_MARKER);
  gst::set_source_maps(in, {picture_as_it_is(4, 2, false), picture_as_it_is(8, 6, false)});
  ASSERT_EQ(demux.push(in), GST_FLOW_OK);
  for (size_t i = 0; i < 2; ++i) {
    const auto out = demux.take(pad_name(i));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5u);
    EXPECT_EQ(GST_BUFFER_DTS(out.get()), 4u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
    EXPECT_EQ(GST_BUFFER_OFFSET(out.get()), 2u);
    EXPECT_TRUE(GST_BUFFER_FLAG_IS_SET(out.get(), GST_BUFFER_FLAG_MARKER));
    const auto maps = gst::source_maps(out.get());
    ASSERT_EQ(maps.size(), 1u);
    EXPECT_EQ(maps[0].width, i == 0 ? 4u : 8u);
  }
  in = make_frame({Bytes(24), Bytes(144)});
  gst::set_source_maps(in, {picture_as_it_is(9, 9, false)});
  ASSERT_EQ(demux.push(in), GST_FLOW_OK);
  for (size_t i = 0; i < 2; ++i) {
    const auto out = demux.take(pad_name(i));
    ASSERT_EQ(gst::source_maps(out.get()).size(), 1u) << "a map for all tensors is kept";
    EXPECT_EQ(gst::source_maps(out.get())[0].width, 9u);
  }
}

TEST(TensorDemux, KeepsRegionsOfABatchForEveryTensor) {
  Branches demux("tensor_demux");
  demux.caps(test::tensors("uint8,uint8", "3:4:2:2,5:2"));
  GstBuffer* in = make_frame({Bytes(48), Bytes(10)});
  gst::set_source_maps(in, {picture_as_it_is(4, 2, false), picture_as_it_is(8, 6, false)},
                       gst::MapsOf::Regions);
  ASSERT_EQ(demux.push(in), GST_FLOW_OK);
  for (const char* name : {"src_0", "src_1"}) {
    const auto out = demux.take(name);
    EXPECT_EQ(gst::maps_of(out.get()), gst::MapsOf::Regions);
    EXPECT_EQ(gst::source_maps(out.get()).size(), 2u) << "the same number as there are tensors";
  }
}

TEST(TensorDemux, FlexibleFramesMayHaveMoreOrFewerTensors) {
  Branches demux("tensor_demux");
  demux.caps(kFlexibleBranch);
  ASSERT_EQ(demux.push(frame(2, true)), GST_FLOW_OK);
  ASSERT_EQ(demux.push(frame(1, true)), GST_FLOW_OK);
  ASSERT_EQ(demux.push(frame(3, true)), GST_FLOW_OK);
  EXPECT_EQ(demux.branch("src_0").buffers.size(), 3u);
  EXPECT_EQ(demux.branch("src_1").buffers.size(), 2u);
  EXPECT_EQ(demux.branch("src_2").buffers.size(), 1u);
  EXPECT_EQ(demux.warning(), "");
  EXPECT_EQ(demux.no_more_pads_count(), 1);
}

}  // namespace tensor_demux_test
}  // namespace weir::test
