// Video caps and buffers as the pictures that core/preprocess reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <span>

#include "core/preprocess/plan.hpp"
#include "gstcpp/mapped_video.hpp"
#include "weir/result.hpp"

namespace weir {

// FORMAT_UNSUPPORTED: another format, or a colour matrix that is not known.
Result<preprocess::Picture> picture_of(const GstVideoInfo& video);

// Where the picture of one buffer lies: GstVideoMeta and GstVideoCropMeta, or else the caps.
struct PictureSize {
  uint32_t width = 0, height = 0;
  std::optional<preprocess::Rect> crop;
  bool operator==(const PictureSize&) const = default;
};
PictureSize size_of_picture(const GstVideoInfo& video, GstBuffer* buffer);
// Leaves `part` of the picture, or of its crop where there is one. OPTION_VALUE: it is not within.
Status narrow(PictureSize* picture, const std::optional<preprocess::Rect>& part);

// A buffer's planes, mapped for as long as the object lives.
class MappedPicture {
 public:
  // Once. FRAME_SIZE when the buffer is shorter than its metadata or caps say, FORMAT_UNSUPPORTED
  // when its metadata are of another picture, MAP_FAILED, OUT_OF_MEMORY.
  Status map(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags = GST_MAP_READ);
  const preprocess::Planes& planes() const noexcept { return planes_; }
  // All that is mapped for a plane, after map() with GST_MAP_WRITE too.
  std::span<std::byte> writable(size_t plane) const noexcept {
    return mapped_.planes()[plane].bytes;
  }
  // By merging the memories of the buffer, where a plane continues in the next one.
  size_t bytes_copied() const noexcept { return mapped_.bytes_copied(); }

 private:
  gst::MappedVideo mapped_;
  preprocess::Planes planes_;
};

}  // namespace weir
