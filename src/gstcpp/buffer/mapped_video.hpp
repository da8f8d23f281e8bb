// MappedVideo: the planes of a video buffer, mapped for the lifetime of the object; and whether a
// buffer fits its caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

class MappedVideo {
 public:
  struct Plane {
    std::span<std::byte> bytes;  // mapped memory
    size_t offset = 0;           // of the first row, in `bytes`
    ptrdiff_t stride = 0;        // bytes from one row to the next; may be negative
  };

  MappedVideo() = default;
  MappedVideo(const MappedVideo&) = delete;
  MappedVideo& operator=(const MappedVideo&) = delete;
  ~MappedVideo();

  // Maps the buffer; call it once. Each plane is mapped at least as far as its rows reach within
  // the buffer. If a plane continues in the next memory, the memories are merged into a copy. With
  // GST_MAP_WRITE the buffer must be writable and keeps the merged memory.
  // Preconditions: check_video_meta() accepts the buffer's GstVideoMeta and its planes begin within
  // the buffer, or check_video_size() accepts a buffer without it. Callers check that each row that
  // they read is within `bytes`.
  // Errors: MAPPING_FAILED, OUT_OF_MEMORY.
  Status map(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags);

  // One for each plane of the format.
  const std::array<Plane, GST_VIDEO_MAX_PLANES>& planes() const noexcept { return planes_; }
  size_t bytes_copied() const noexcept { return copied_; }

 private:
  Status map_merged(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags);

  GstVideoFrame frame_;
  bool frame_mapped_ = false;
  Ref<GstMemory> merged_;    // all bytes of a buffer with several memories
  MappedMemory merged_map_;  // destroyed before merged_
  size_t copied_ = 0;
  std::array<Plane, GST_VIDEO_MAX_PLANES> planes_{};
};

// FORMAT_UNSUPPORTED unless the metadata describes a picture of the caps' format and of at least
// its size: GStreamer's own mapping logs a critical warning for others. The reader checks offsets
// and strides.
Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta);
// For a buffer without metadata. FRAME_SIZE unless its size is one frame of the caps with
// GStreamer's row padding: a shorter one cannot be mapped, a longer one would lose data.
Status check_video_size(const GstVideoInfo& video, size_t bytes);
// FRAME_SIZE: the buffer is too small for its caps or metadata.
Error video_too_small(std::string offered, std::string needed);

}  // namespace weir::gst
