// tensor_crop before an element that takes views, and the pool for what is copied.
#include <cstring>

#include "elements/tensor_crop/crop_test_support.hpp"

namespace weir::testing {
namespace {

// A tensor_transform between the element and the bare pad.
struct Transformed : Crop {
  explicit Transformed(const char* mode, const char* option, const char* raw = kRaw)
      : Crop("", raw),
        transform(Ref<GstElement>::adopt(GST_ELEMENT(
            gst_object_ref_sink(gst_element_factory_make("tensor_transform", nullptr))))) {
    gst_util_set_object_arg(G_OBJECT(transform.get()), "mode", mode);
    g_object_set(transform.get(), "option", option, nullptr);
    const auto source = pad_of(element(), "src"), in = pad_of(transform.get(), "sink"),
               out = pad_of(transform.get(), "src");
    gst_pad_unlink(source.get(), sink());
    EXPECT_EQ(gst_pad_link(source.get(), in.get()), GST_PAD_LINK_OK);
    EXPECT_EQ(gst_pad_link(out.get(), sink()), GST_PAD_LINK_OK);
    gst_element_set_state(transform.get(), GST_STATE_PLAYING);
  }
  ~Transformed() {
    stop();
    gst_element_set_state(transform.get(), GST_STATE_NULL);
  }
  static Ref<GstPad> pad_of(GstElement* element, const char* name) {
    return Ref<GstPad>::adopt(gst_element_get_static_pad(element, name));
  }
  uint64_t transform_stat(const char* name) const { return test::stat(transform.get(), name); }

  Ref<GstElement> transform;
};

constexpr char kAdd[] = "add:100";

// A tensor of tensor_transform, whose headers say static.
Bytes transformed(const Shape& shape, const Bytes& payload) {
  Bytes out = header_of(ElementType::UInt8, shape, Format::Static);
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
Bytes plus_100(const Shape& shape, Bytes payload) {
  for (auto& byte : payload) byte = static_cast<uint8_t>(byte + 100);
  return transformed(shape, payload);
}

TEST(CropViews, GoToATransformThatTakesThem) {
  Transformed crop("arithmetic", kAdd);
  for (int i = 0; i < 3; ++i) crop.push_both(info_of({1, 0, 2, 1, 3, 1, 2, 2}));
  ASSERT_EQ(crop.buffers().size(), 3u);
  for (const auto& buffer : crop.buffers())
    EXPECT_EQ(memories_of(buffer.get()),
              (std::vector<Bytes>{plus_100({2, 2, 1}, {2, 3, 4, 5}),
                                  plus_100({2, 2, 2}, {16, 17, 18, 19, 26, 27, 28, 29})}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
  EXPECT_EQ(crop.stat("regions-shared"), 6u);
  EXPECT_EQ(crop.transform_stat("fused-frames"), 3u);
  EXPECT_EQ(crop.transform_stat("pool-allocated"), 2u) << "from the second frame of these sizes on";
}

TEST(CropViews, OfFlexibleFramesBeginBehindTheHeader) {
  Transformed crop("arithmetic", kAdd, kInfo);
  crop.push_both(buffer_of({region({2, 5, 4}, picture())}, 0), info_of({3, 1, 2, 1}), 0);
  ASSERT_EQ(crop.buffers().size(), 1u);
  EXPECT_EQ(memories_of(crop.buffers()[0].get()),
            (std::vector<Bytes>{plus_100({2, 2, 1}, {16, 17, 18, 19})}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
}

TEST(CropViews, WhoeverMapsOneGetsTheRegionAndItIsCounted) {
  Transformed crop("arithmetic", kAdd);
  std::vector<std::vector<Bytes>> seen;
  const auto in = Transformed::pad_of(crop.transform.get(), "sink");
  gst_pad_add_probe(
      in.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer into) {
        static_cast<std::vector<std::vector<Bytes>>*>(into)->push_back(
            memories_of(GST_PAD_PROBE_INFO_BUFFER(info)));
        return GST_PAD_PROBE_OK;
      },
      &seen, nullptr);
  for (int i = 0; i < 2; ++i) crop.push_both(info_of({1, 0, 2, 1}));
  const std::vector<Bytes> cut{region({2, 2, 1}, {2, 3, 4, 5})};
  EXPECT_EQ(seen, (std::vector<std::vector<Bytes>>{cut, cut}));
  EXPECT_EQ(memories_of(crop.buffers().at(1).get()),
            (std::vector<Bytes>{plus_100({2, 2, 1}, {2, 3, 4, 5})}));
  EXPECT_EQ(crop.stat("regions-shared"), 1u) << "the first frame shows that it is of no use";
  EXPECT_EQ(crop.stat("bytes-copied"), 8u);
  EXPECT_EQ(crop.transform_stat("fused-frames"), 0u);
}

TEST(CropViews, OfOtherSizesGetBuffersOfTheirOwn) {
  Transformed crop("arithmetic", kAdd);
  for (const uint32_t width : {1u, 1u, 2u, 1u}) crop.push_both(info_of({1, 0, width, 1}));
  const std::vector<Bytes> one{plus_100({2, 1, 1}, {2, 3})}, two{plus_100({2, 2, 1}, {2, 3, 4, 5})};
  std::vector<std::vector<Bytes>> got;
  for (const auto& buffer : crop.buffers()) got.push_back(memories_of(buffer.get()));
  EXPECT_EQ(got, (std::vector<std::vector<Bytes>>{one, one, two, one}));
  EXPECT_EQ(crop.stat("bytes-copied"), 0u);
}

TEST(CropViews, AreNotForAnElementThatNeedsTheWholeTensor) {
  Transformed crop("transpose", "0:2:1:3");
  crop.push_both(info_of({1, 0, 1, 2}));
  EXPECT_EQ(memories_of(crop.buffers().at(0).get()),
            (std::vector<Bytes>{transformed({2, 2, 1}, {2, 3, 12, 13})}));
  EXPECT_EQ(crop.stat("regions-shared"), 0u);
  EXPECT_EQ(crop.stat("bytes-copied"), 4u);
}

TEST(CropViews, AreNotForMoreThanABufferHolds) {
  Crop crop;
  std::vector<uint32_t> numbers;
  for (uint32_t i = 0; i < 17; ++i) numbers.insert(numbers.end(), {i % 5, i % 4, 1, 1});
  crop.push_both(info_of(numbers));
  EXPECT_EQ(crop.stat("regions-shared"), 0u);
  EXPECT_EQ(crop.stat("bytes-copied"), 34u);
}

TEST(CropPool, BuffersOfRegionsOfTheSameSizesComeBack) {
  for (const uint32_t regions : {2u, 20u}) {
    Crop crop;
    gst_pad_add_probe(
        crop.sink(), GST_PAD_PROBE_TYPE_BUFFER,
        [](GstPad*, GstPadProbeInfo*, gpointer) { return GST_PAD_PROBE_DROP; }, nullptr, nullptr);
    for (uint32_t frame = 0; frame < 6; ++frame) {
      std::vector<uint32_t> numbers;
      for (uint32_t i = 0; i < regions; ++i)
        numbers.insert(numbers.end(), {(frame + i) % 4, frame % 3, 2, 2});
      crop.push_both(info_of(numbers));
    }
    EXPECT_EQ(crop.stat("pool-allocated"), 1u);
    crop.push_both(info_of({0, 0, 1, 1}));
    EXPECT_EQ(crop.stat("regions"), 6 * regions + 1);
  }
}

TEST(CropPool, BuffersThatAreKeptStayAsTheyAre) {
  Crop crop;
  for (uint32_t x = 0; x < 4; ++x) crop.push_both(info_of({x, 1, 1, 2}));
  const auto buffers = crop.buffers();
  ASSERT_EQ(buffers.size(), 4u);
  for (uint8_t x = 0; x < 4; ++x) {
    const auto first = static_cast<uint8_t>(10 + 2 * x), second = static_cast<uint8_t>(first + 10);
    EXPECT_EQ(memories_of(buffers[x].get()),
              (std::vector<Bytes>{region({2, 1, 2}, {first, static_cast<uint8_t>(first + 1), second,
                                                     static_cast<uint8_t>(second + 1)})}));
  }
  EXPECT_EQ(crop.stat("pool-allocated"), 3u);
}

}  // namespace
}  // namespace weir::testing
