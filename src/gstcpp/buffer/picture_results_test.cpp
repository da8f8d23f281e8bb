// Tests of masks of regions in buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/picture_results.hpp"

#include "elements/tests/element_test_support.hpp"

namespace weir::gst {
namespace picture_results_test {

using namespace weir::test;
using Numbers = std::vector<uint16_t>;

struct Layout {
  GstVideoFormat format = GST_VIDEO_FORMAT_GRAY8;
  guint width = 2, height = 2;
  gsize offset = 0;
  gint stride = 2;
};
Numbers read(GstBuffer* buffer, const Layout& layout) {
  const auto mask = Ref<GstBuffer>::adopt(buffer);
  gsize offset[GST_VIDEO_MAX_PLANES] = {layout.offset};
  gint stride[GST_VIDEO_MAX_PLANES] = {layout.stride};
  gst_buffer_add_video_meta_full(mask.get(), GST_VIDEO_FRAME_FLAG_NONE, layout.format, layout.width,
                                 layout.height, 1, offset, stride);
  return read_mask(mask.get()).numbers;
}

TEST(Mask, IsReadAsItWasMade) {
  for (const Numbers& numbers : {Numbers{0, 1, 2, 3, 4, 255}, Numbers{0, 1, 2, 256, 4, 65535}}) {
    const auto mask = make_mask({3, 2, numbers});
    const auto read = read_mask(mask.get());
    EXPECT_EQ(read.width, 3u);
    EXPECT_EQ(read.height, 2u);
    EXPECT_EQ(read.numbers, numbers);
    EXPECT_EQ(gst_buffer_get_size(mask.get()), numbers[3] > 255 ? 12u : 6u);
  }
}

TEST(Mask, HasItsLayout) {
  EXPECT_EQ(read(frame(Bytes{9, 1, 2, 9, 3, 4}), {.offset = 1, .stride = 3}),
            (Numbers{1, 2, 3, 4}));
  EXPECT_EQ(read(frame(Bytes{1, 0, 0, 2}),
                 {.format = GST_VIDEO_FORMAT_GRAY16_LE, .height = 1, .stride = 4}),
            (Numbers{1, 512}));
  EXPECT_EQ(read(frame(Bytes{1, 0, 0, 2}),
                 {.format = GST_VIDEO_FORMAT_GRAY16_BE, .height = 1, .stride = 4}),
            (Numbers{256, 2}));
  GstBuffer* parts = frame(Bytes{1, 2, 3});
  gst_buffer_append_memory(parts, make_memory({4}));
  EXPECT_EQ(read(parts, {}), (Numbers{1, 2, 3, 4}));
}

TEST(Mask, ThatDoesNotFitItsLayoutIsEmpty) {
  for (const Layout& layout : {Layout{.height = 3},
                               {.offset = 1},
                               {.offset = 99},
                               {.stride = 3},
                               {.stride = 1},
                               {.stride = -2},
                               {.stride = 0},
                               {.width = 0},
                               {.height = 0},
                               {.height = G_MAXUINT},
                               {.format = GST_VIDEO_FORMAT_RGB},
                               {.format = GST_VIDEO_FORMAT_GRAY16_LE}})
    EXPECT_EQ(read(frame(Bytes{1, 2, 3, 4}), layout), Numbers{});
  EXPECT_EQ(read_mask(nullptr).numbers, Numbers{});
  const auto without_layout = Ref<GstBuffer>::adopt(frame(Bytes(4)));
  EXPECT_EQ(read_mask(without_layout.get()).numbers, Numbers{});
}

}  // namespace picture_results_test
}  // namespace weir::gst
