// tensor_crop with a downstream element that accepts deferred memory, and its pool for copies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "core/tensor/packed_tensors.hpp"
#include "elements/tensor_crop/crop_test_support.hpp"

namespace weir::test {
namespace crop_views_test {

// A tensor_transform between the element and the bare pad.
struct Transformed : Crop {
  explicit Transformed(const char* mode, const char* option, const char* raw = kRaw)
      : Crop("", raw),
        transform(Ref<GstElement>::adopt(GST_ELEMENT(
            gst_object_ref_sink(gst_element_factory_make("tensor_transform", nullptr))))) {
    gst_util_set_object_arg(G_OBJECT(transform.get()), "mode", mode);
    g_object_set(transform.get(), "option", option, nullptr);
    const auto source = get_pad(element(), "src"), in = get_pad(transform.get(), "sink"),
               out = get_pad(transform.get(), "src");
    gst_pad_unlink(source.get(), sink());
    EXPECT_EQ(gst_pad_link(source.get(), in.get()), GST_PAD_LINK_OK);
    EXPECT_EQ(gst_pad_link(out.get(), sink()), GST_PAD_LINK_OK);
    gst_element_set_state(transform.get(), GST_STATE_PLAYING);
  }
  ~Transformed() {
    stop();
    gst_element_set_state(transform.get(), GST_STATE_NULL);
  }
  static Ref<GstPad> get_pad(GstElement* element, const char* name) {
    return Ref<GstPad>::adopt(gst_element_get_static_pad(element, name));
  }
  uint64_t transform_stat(const char* name) const { return test::stat(transform.get(), name); }

  Ref<GstElement> transform;
};

constexpr char kAdd[] = "add:100";

// An output tensor of tensor_transform, whose headers give format static.
Bytes transformed(const Shape& shape, const Bytes& payload) {
  Bytes out =
      make_header(ElementType::UInt8, Shape{shape[0], shape[1], shape[2], 1}, Format::Static);
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
Bytes plus_100(const Shape& shape, Bytes payload) {
  for (auto& byte : payload) byte = static_cast<uint8_t>(byte + 100);
  return transformed(shape, payload);
}

TEST(CropViews, AreDeferredToATransformThatAcceptsThem) {
  Transformed crop("arithmetic", kAdd);
  for (int i = 0; i < 3; ++i) crop.push_both(make_info({1, 0, 2, 1, 3, 1, 2, 2}));
  ASSERT_EQ(crop.buffers().size(), 3u);
  for (const auto& buffer : crop.buffers())
    EXPECT_EQ(read_memories(buffer.get()),
              (std::vector<Bytes>{plus_100({2, 2, 1}, {2, 3, 4, 5}),
                                  plus_100({2, 2, 2}, {16, 17, 18, 19, 26, 27, 28, 29})}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
  EXPECT_EQ(crop.stat("regions-shared"), 6u);
  EXPECT_EQ(crop.transform_stat("fused-frames"), 3u);
  EXPECT_EQ(crop.transform_stat("pool-allocated"), 2u) << "from the second frame of these sizes on";
}

TEST(CropViews, OfFlexibleFramesStartAfterTheHeader) {
  Transformed crop("arithmetic", kAdd, kInfo);
  crop.push_both(make_buffer({region({2, 5, 4}, picture())}, 0), make_info({3, 1, 2, 1}), 0);
  ASSERT_EQ(crop.buffers().size(), 1u);
  EXPECT_EQ(read_memories(crop.buffers()[0].get()),
            (std::vector<Bytes>{plus_100({2, 2, 1}, {16, 17, 18, 19})}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
}

TEST(CropViews, AreComputedAndCountedWhenMapped) {
  Transformed crop("arithmetic", kAdd);
  std::vector<std::vector<Bytes>> seen;
  const auto in = Transformed::get_pad(crop.transform.get(), "sink");
  gst_pad_add_probe(
      in.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer into) {
        static_cast<std::vector<std::vector<Bytes>>*>(into)->push_back(
            read_memories(GST_PAD_PROBE_INFO_BUFFER(info)));
        return GST_PAD_PROBE_OK;
      },
      &seen, nullptr);
  for (int i = 0; i < 2; ++i) crop.push_both(make_info({1, 0, 2, 1}));
  const std::vector<Bytes> cut{region({2, 2, 1}, {2, 3, 4, 5})};
  EXPECT_EQ(seen, (std::vector<std::vector<Bytes>>{cut, cut}));
  EXPECT_EQ(read_memories(crop.buffers().at(1).get()),
            (std::vector<Bytes>{plus_100({2, 2, 1}, {2, 3, 4, 5})}));
  EXPECT_EQ(crop.stat("regions-shared"), 1u)
      << "the first frame shows that deferring does not help";
  EXPECT_EQ(crop.stat("bytes-copied"), 8u);
  EXPECT_EQ(crop.transform_stat("fused-frames"), 0u);
}

TEST(CropViews, OfOtherSizesGetSeparateBuffers) {
  Transformed crop("arithmetic", kAdd);
  for (const uint32_t width : {1u, 1u, 2u, 1u}) crop.push_both(make_info({1, 0, width, 1}));
  const std::vector<Bytes> one{plus_100({2, 1, 1}, {2, 3})}, two{plus_100({2, 2, 1}, {2, 3, 4, 5})};
  std::vector<std::vector<Bytes>> got;
  for (const auto& buffer : crop.buffers()) got.push_back(read_memories(buffer.get()));
  EXPECT_EQ(got, (std::vector<std::vector<Bytes>>{one, one, two, one}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
}

TEST(CropViews, AreNotUsedForAnElementThatNeedsTheWholeTensor) {
  Transformed crop("transpose", "0:2:1:3");
  crop.push_both(make_info({1, 0, 1, 2}));
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{transformed({2, 2, 1}, {2, 3, 12, 13})}));
  EXPECT_EQ(crop.stat("regions-shared"), 0u);
  EXPECT_EQ(crop.stat("bytes-copied"), 4u);
}

// `count` regions of one or two pixels at positions offset by `shift`, and the expected output.
struct ManyRegions {
  ManyRegions(uint32_t count, uint32_t shift) {
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t x = (i + shift) % 4, y = (i + 3 * shift) % 4, width = 1 + (i + shift) % 2;
      numbers.insert(numbers.end(), {x, y, width, 1});
      const Bytes all = picture();
      const auto from = all.begin() + 10 * y + 2 * x;
      cut.push_back(region({2, width, 1}, {from, from + 2 * width}));
      plus.push_back(plus_100({2, width, 1}, {from, from + 2 * width}));
    }
  }
  std::vector<uint32_t> numbers;
  std::vector<Bytes> cut, plus;
};
// The tensors of a frame, including those in the packed 16th memory.
std::vector<Bytes> get_tensors(GstBuffer* buffer) {
  std::vector<Bytes> out = read_memories(buffer);
  if (out.size() < kMemoryLimit) return out;
  const Bytes last = out.back();
  const auto bytes = std::as_bytes(std::span(last));
  if (!is_packed(bytes)) return out;
  out.pop_back();
  const auto ranges = read_packed_tensors(bytes, Format::Flexible);
  EXPECT_TRUE(ranges);
  for (const ByteRange& range : *ranges) {
    const auto from = last.begin() + static_cast<std::ptrdiff_t>(range.offset);
    out.emplace_back(from, from + static_cast<std::ptrdiff_t>(range.size));
  }
  return out;
}

TEST(CropViews, ExistForEachRegion) {
  for (const uint32_t count : {15u, 16u, 17u, 40u, 256u}) {
    Transformed crop("arithmetic", kAdd);
    for (uint32_t frame = 0; frame < 4; ++frame)  // sizes change, and two frames have the same
      crop.push_both(make_info(ManyRegions(count, frame / 2).numbers));
    ASSERT_EQ(crop.buffers().size(), 4u);
    for (uint32_t frame = 0; frame < 4; ++frame)
      EXPECT_EQ(get_tensors(crop.buffers()[frame].get()), ManyRegions(count, frame / 2).plus)
          << count << " regions, frame " << frame;
    EXPECT_EQ(crop.stat("bytes-copied"), 0u) << count;
    EXPECT_EQ(crop.stat("regions-shared"), 4u * count);
    EXPECT_EQ(crop.transform_stat("fused-frames"), 4u);
  }
}

// In the layout of a copied frame.
TEST(CropViews, BeyondTheMemoryLimitArePackedWhenMapped) {
  const ManyRegions many(40, 1);
  Transformed crop("arithmetic", kAdd);
  std::vector<Bytes> seen;
  const auto in = Transformed::get_pad(crop.transform.get(), "sink");
  gst_pad_add_probe(
      in.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer into) {
        *static_cast<std::vector<Bytes>*>(into) = read_memories(GST_PAD_PROBE_INFO_BUFFER(info));
        return GST_PAD_PROBE_OK;
      },
      &seen, nullptr);
  crop.push_both(make_info(many.numbers));
  Crop copies;
  copies.push_both(make_info(many.numbers));
  EXPECT_EQ(crop.stat("regions-shared"), 40u);
  EXPECT_EQ(copies.stat("regions-shared"), 0u);
  EXPECT_EQ(seen, read_memories(copies.buffers().at(0).get()));
  EXPECT_EQ(get_tensors(copies.buffers()[0].get()), many.cut);
  EXPECT_EQ(get_tensors(crop.buffers().at(0).get()), many.plus);
  EXPECT_EQ(crop.stat("bytes-copied"), copies.stat("bytes-copied"));
}

TEST(CropPool, ReusesBuffersOfRegionsOfTheSameSizes) {
  for (const uint32_t regions : {2u, 20u}) {
    Crop crop;
    gst_pad_add_probe(
        crop.sink(), GST_PAD_PROBE_TYPE_BUFFER,
        [](GstPad*, GstPadProbeInfo*, gpointer) { return GST_PAD_PROBE_DROP; }, nullptr, nullptr);
    for (uint32_t frame = 0; frame < 6; ++frame) {
      std::vector<uint32_t> numbers;
      for (uint32_t i = 0; i < regions; ++i)
        numbers.insert(numbers.end(), {(frame + i) % 4, frame % 3, 2, 2});
      crop.push_both(make_info(numbers));
    }
    EXPECT_EQ(crop.stat("pool-allocated"), 1u);
    crop.push_both(make_info({0, 0, 1, 1}));
    EXPECT_EQ(crop.stat("regions"), 6 * regions + 1);
  }
}

TEST(CropPool, DoesNotReuseHeldBuffers) {
  Crop crop;
  for (uint32_t x = 0; x < 4; ++x) crop.push_both(make_info({x, 1, 1, 2}));
  const auto buffers = crop.buffers();
  ASSERT_EQ(buffers.size(), 4u);
  for (uint8_t x = 0; x < 4; ++x) {
    const auto first = static_cast<uint8_t>(10 + 2 * x), second = static_cast<uint8_t>(first + 10);
    EXPECT_EQ(read_memories(buffers[x].get()),
              (std::vector<Bytes>{region({2, 1, 2}, {first, static_cast<uint8_t>(first + 1), second,
                                                     static_cast<uint8_t>(second + 1)})}));
  }
  EXPECT_EQ(crop.stat("pool-allocated"), 3u);
}

}  // namespace crop_views_test
}  // namespace weir::test
