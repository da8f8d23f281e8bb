// tensor_crop: regions of a frame, their limits, times and maps; and what is refused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/tensor/packed_tensors.hpp"
#include "elements/tensor_crop/crop_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace tensor_crop_test {

TEST(TensorCrop, CropsEachRegion) {
  Crop crop;
  crop.push_both(make_info({1, 0, 2, 1, 3, 1, 2, 2}));
  ASSERT_EQ(crop.buffers().size(), 1u);
  EXPECT_EQ(read_memories(crop.buffers()[0].get()),
            (std::vector<Bytes>{region({2, 2, 1}, {2, 3, 4, 5}),
                                region({2, 2, 2}, {16, 17, 18, 19, 26, 27, 28, 29})}));
  EXPECT_EQ(crop.caps(), "other/tensors, format=(string)flexible, framerate=(fraction)15/1");
  EXPECT_EQ(crop.stat("regions"), 2u);
  EXPECT_EQ(crop.stat("bytes-copied"), 12u);
}

TEST(TensorCrop, ClipsRegionsToTheFrame) {
  Crop crop;
  crop.push_both(make_info({4, 3, 9, 9, 5, 0, 1, 1}));
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{region({2, 1, 1}, {38, 39})}));
  EXPECT_EQ(crop.stat("regions-empty"), 1u);
}

TEST(TensorCrop, SendsAGapForAFrameWithoutRegions) {
  Crop crop;
  auto raw = make_buffer({picture()}, 100);
  GST_BUFFER_DURATION(raw.get()) = 33;
  crop.push_both(raw, make_info({5, 0, 1, 1}), 100);
  EXPECT_TRUE(crop.buffers().empty());
  const auto gaps = crop.events(GST_EVENT_GAP);
  ASSERT_EQ(gaps.size(), 1u);
  GstClockTime start = 0, duration = 0;
  gst_event_parse_gap(gaps[0].get(), &start, &duration);
  EXPECT_EQ(start, 100u);
  EXPECT_EQ(duration, 33u);
}

TEST(TensorCrop, PacksHundredsOfRegions) {
  Crop crop;
  std::vector<uint32_t> numbers;
  for (uint32_t i = 0; i < 300; ++i) numbers.insert(numbers.end(), {i % 5, i % 4, 1, 1});
  crop.push_both(make_info(numbers));
  const auto out = read_memories(crop.buffers().at(0).get());
  ASSERT_EQ(out.size(), 16u);
  const std::span packed(reinterpret_cast<const std::byte*>(out[15].data()), out[15].size());
  const auto ranges = read_packed_tensors(packed, Format::Flexible);
  ASSERT_TRUE(ranges);
  ASSERT_EQ(ranges->size(), 241u);
  for (size_t i = 0; i < 256; ++i) {
    const auto value = static_cast<uint8_t>(10 * (i % 4) + 2 * (i % 5));
    const size_t at = i < 15 ? 0 : (*ranges)[i - 15].offset;
    const Bytes& memory = i < 15 ? out[i] : out[15];
    ASSERT_EQ(memory[at + kTensorHeaderBytes], value) << i;
    ASSERT_EQ(memory[at + kTensorHeaderBytes + 1], value + 1) << i;
  }
  EXPECT_EQ(crop.stat("regions-beyond-limit"), 44u);
}

TEST(TensorCrop, AcceptsFlexibleFramesOfAnyType) {
  Crop crop("", "other/tensors,format=flexible,framerate=30/1");
  Bytes raw = make_header(ElementType::Float32, Shape{1, 2, 2}, Format::Static);
  const float numbers[] = {1, 2, 3, 4};
  raw.resize(raw.size() + sizeof numbers);
  std::memcpy(raw.data() + kTensorHeaderBytes, numbers, sizeof numbers);
  crop.push_both(make_buffer({raw}, 0), make_info({1, 0, 1, 2}), 0);
  const auto out = read_memories(crop.buffers().at(0).get());
  ASSERT_EQ(out.size(), 1u);
  Bytes expected = make_header(ElementType::Float32, Shape{1, 1, 2, 1}, Format::Flexible);
  const float part[] = {2, 4};
  expected.resize(expected.size() + sizeof part);
  std::memcpy(expected.data() + kTensorHeaderBytes, part, sizeof part);
  EXPECT_EQ(out[0], expected);
}

TEST(TensorCrop, CopiesMetadataAndTimeOfTheFrame) {
  Crop crop;
  auto raw = make_buffer({picture()}, 70);
  GST_BUFFER_DURATION(raw.get()) = 5;
  GST_BUFFER_OFFSET(raw.get()) = 9;
  crop.push_both(raw, make_info({0, 0, 1, 1}), 900);
  GstBuffer* out = crop.buffers().at(0).get();
  EXPECT_EQ(GST_BUFFER_PTS(out), 70u);
  EXPECT_EQ(GST_BUFFER_DURATION(out), 5u);
}

TEST(TensorCrop, KeepsFramesWithoutTimeUntimed) {
  Crop crop;
  crop.push_both(make_buffer({picture()}, GST_CLOCK_TIME_NONE), make_info({0, 0, 1, 1}), 900);
  EXPECT_FALSE(GST_BUFFER_PTS_IS_VALID(crop.buffers().at(0).get()));
}

TEST(TensorCrop, AdjustsTheSourceMapOfEachRegion) {
  Crop crop;
  auto raw = make_buffer({picture()}, 0);
  SourceMap map = picture_as_it_is(5, 4, false).of_part(2, 10, 3, 20, 5, 4);
  gst::set_source_maps(raw.get(), {map});
  crop.push_both(raw, make_info({1, 2, 3, 1, 0, 0, 5, 4}), 0);
  const auto maps = gst::source_maps(crop.buffers().at(0).get());
  ASSERT_EQ(maps.size(), 2u);
  const Point corner = maps[0].to_source({0, 0});
  EXPECT_DOUBLE_EQ(corner.x, 2 * 1 + 10);
  EXPECT_DOUBLE_EQ(corner.y, 3 * 2 + 20);
  EXPECT_EQ(maps[0].width, 3u);
  EXPECT_EQ(maps[0].height, 1u);
  EXPECT_DOUBLE_EQ(maps[1].to_source({5, 4}).x, 20);
}

TEST(TensorCrop, LatenessDropsTheOlder) {
  Crop crop("lateness=1");
  auto raw = crop.push_later(0, make_buffer({picture()}, 10 * GST_MSECOND));
  EXPECT_EQ(crop.push(1, make_info({0, 0, 1, 1}), 8 * GST_MSECOND), GST_FLOW_OK);
  EXPECT_TRUE(crop.buffers().empty());
  EXPECT_EQ(crop.push(1, make_info({1, 0, 1, 1}), 11 * GST_MSECOND), GST_FLOW_OK);
  EXPECT_EQ(raw.get(), GST_FLOW_OK);
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{region({2, 1, 1}, {2, 3})}));
  crop.stop();
  EXPECT_EQ(crop.stat("dropped-policy"), 1u);
  EXPECT_EQ(crop.stat("held"), 0u);
}

TEST(TensorCrop, PairsFramesInOrderWithoutLateness) {
  Crop crop;
  crop.push_both(make_buffer({picture()}, 10 * GST_MSECOND), make_info({0, 0, 1, 1}), GST_SECOND);
  EXPECT_EQ(crop.buffers().size(), 1u);
}

TEST(TensorCrop, EndsWithEitherInput) {
  for (const size_t ended : {0u, 1u}) {
    Crop crop;
    auto push = crop.push_later(1 - ended, Bytes(200), 0);
    crop.wait_for_stat("received", 1);
    crop.event(ended, gst_event_new_eos());
    push.get();
    EXPECT_EQ(crop.events(GST_EVENT_EOS).size(), 1u);
    EXPECT_EQ(crop.stat("dropped-eos"), 1u);
  }
}

TEST(TensorCrop, StopWakesWaitingThreads) {
  for (const size_t waiting : {0u, 1u}) {
    Crop crop;
    auto push = crop.push_later(waiting, Bytes(200), 0);
    crop.wait_for_stat("received", 1);
    crop.stop();
    EXPECT_EQ(push.get(), GST_FLOW_FLUSHING);
    EXPECT_EQ(crop.stat("dropped-flush"), 1u);
  }
}

void expect_refused(Ref<GstBuffer> raw, const Bytes& info, const char* code) {
  Crop crop;
  auto first = crop.push_later(0, raw), second = crop.push_later(1, info, 0);
  EXPECT_TRUE(first.get() == GST_FLOW_ERROR || second.get() == GST_FLOW_ERROR);
  EXPECT_SAYS(crop.error(), code);
  EXPECT_TRUE(crop.buffers().empty());
}

TEST(TensorCrop, RejectsFramesOfTheWrongSize) {
  expect_refused(make_buffer({Bytes(39)}, 0), make_info({0, 0, 1, 1}), "WEIR-2004");
  expect_refused(make_buffer({Bytes(39)}, 0), make_info({0, 0, 1, 1}),
                 "39 bytes in memory 0 on raw");
}

TEST(TensorCrop, RejectsInvalidHeaders) {
  Bytes info = make_info({0, 0, 1, 1});
  info.pop_back();
  expect_refused(make_buffer({picture()}, 0), info, "WEIR-2005");
  expect_refused(make_buffer({picture()}, 0), Bytes(16), "WEIR-2005");
}

TEST(TensorCrop, RejectsSparseRegions) {
  TensorHeader header;
  header.spec = {ElementType::UInt8, Shape{4, 1}, ""};
  header.format = Format::Sparse;
  Bytes info(kTensorHeaderBytes);
  write_tensor_header(header, std::span<std::byte, kTensorHeaderBytes>(
                                  reinterpret_cast<std::byte*>(info.data()), kTensorHeaderBytes));
  expect_refused(make_buffer({picture()}, 0), info, "WEIR-2002");
}

}  // namespace tensor_crop_test
}  // namespace weir::test
