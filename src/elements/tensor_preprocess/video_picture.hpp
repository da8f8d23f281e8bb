// Converts video caps and buffers to the pictures that core/preprocess reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <span>

#include "core/preprocess/plan.hpp"
#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/mapped_video.hpp"
#include "weir/result.hpp"

namespace weir {

// FORMAT_UNSUPPORTED: an unsupported format or colour matrix.
Result<preprocess::Picture> make_picture(const GstVideoInfo& video);

// The position of a buffer's picture, from GstVideoMeta and GstVideoCropMeta, or else the caps.
struct CroppedPicture {
  uint32_t width = 0, height = 0;
  std::optional<Rect> crop;
  bool operator==(const CroppedPicture&) const = default;
};
CroppedPicture size_of_picture(const GstVideoInfo& video, GstBuffer* buffer);
// Crops the picture, or its existing crop, to `part`. OPTION_VALUE: `part` is outside.
Status narrow(CroppedPicture* picture, const std::optional<Rect>& part);

// A buffer's planes, mapped for the lifetime of the object.
class MappedPicture {
 public:
  // Call it once. FRAME_SIZE when the buffer is shorter than its metadata or caps require,
  // FORMAT_UNSUPPORTED when its metadata describes another picture, MAPPING_FAILED, OUT_OF_MEMORY.
  Status map(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags = GST_MAP_READ);
  const preprocess::Planes& planes() const noexcept { return planes_; }
  // All mapped bytes of a plane; also after map() with GST_MAP_WRITE.
  std::span<std::byte> writable(size_t plane) const noexcept {
    return mapped_.planes()[plane].bytes;
  }
  // Returns the bytes copied to merge the buffer's memories when a plane spans them.
  size_t bytes_copied() const noexcept { return mapped_.bytes_copied(); }

 private:
  gst::MappedVideo mapped_;
  preprocess::Planes planes_;
};

}  // namespace weir
