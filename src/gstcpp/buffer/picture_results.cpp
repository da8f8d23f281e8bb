// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/picture_results.hpp"

#include <algorithm>

namespace weir::gst {
namespace {

// Bytes; 0 for other formats.
size_t cell_size(GstVideoFormat format) {
  if (format == GST_VIDEO_FORMAT_GRAY8) return 1;
  return format == GST_VIDEO_FORMAT_GRAY16_LE || format == GST_VIDEO_FORMAT_GRAY16_BE ? 2 : 0;
}
uint16_t read_cell(const guint8* cell, GstVideoFormat format) {
  if (format == GST_VIDEO_FORMAT_GRAY8) return *cell;
  return format == GST_VIDEO_FORMAT_GRAY16_LE ? GST_READ_UINT16_LE(cell) : GST_READ_UINT16_BE(cell);
}

}  // namespace

GQuark make_quark(const std::string& label) {
  return g_quark_from_string(label.empty() ? "object" : label.c_str());
}

Ref<GstBuffer> make_mask(const results::RegionGrid& grid) {
  const auto& numbers = grid.numbers;
  const bool is_wide = std::any_of(numbers.begin(), numbers.end(), [](auto n) { return n > 255; });
  Ref<GstBuffer> out;
  if (is_wide) {
    out = Ref<GstBuffer>::adopt(gst_buffer_new_memdup(numbers.data(), numbers.size() * 2));
  } else {
    auto* cells = static_cast<guint8*>(g_malloc(numbers.size()));
    std::transform(numbers.begin(), numbers.end(), cells,
                   [](uint16_t number) { return static_cast<guint8>(number); });
    out = Ref<GstBuffer>::adopt(gst_buffer_new_wrapped(cells, numbers.size()));
  }
  gsize offset[GST_VIDEO_MAX_PLANES] = {0};
  gint stride[GST_VIDEO_MAX_PLANES] = {static_cast<gint>(grid.width * (is_wide ? 2 : 1))};
  gst_buffer_add_video_meta_full(out.get(), GST_VIDEO_FRAME_FLAG_NONE,
                                 is_wide ? GST_VIDEO_FORMAT_GRAY16_LE : GST_VIDEO_FORMAT_GRAY8,
                                 grid.width, grid.height, 1, offset, stride);
  return out;
}

results::RegionGrid read_mask(GstBuffer* mask) {
  const GstVideoMeta* meta = mask ? gst_buffer_get_video_meta(mask) : nullptr;
  const size_t cell = meta ? cell_size(meta->format) : 0;
  if (cell == 0 || meta->stride[0] <= 0 || meta->width == 0 || meta->height == 0) return {};
  GstMapInfo map;
  if (!gst_buffer_map(mask, &map, GST_MAP_READ)) return {};
  const size_t row = meta->width * cell, offset = meta->offset[0];
  const auto stride = static_cast<size_t>(meta->stride[0]);
  const bool fits = row <= stride && offset <= map.size && row <= map.size - offset &&
                    meta->height - 1 <= (map.size - offset - row) / stride;
  results::RegionGrid out;
  if (fits) {
    out.width = meta->width;
    out.height = meta->height;
    out.numbers.reserve(size_t{out.width} * out.height);
    for (uint32_t y = 0; y < out.height; ++y)
      for (uint32_t x = 0; x < out.width; ++x)
        out.numbers.push_back(read_cell(map.data + offset + y * stride + x * cell, meta->format));
  }
  gst_buffer_unmap(mask, &map);
  return out;
}

}  // namespace weir::gst
