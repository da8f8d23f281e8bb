// PictureWork: what tensor_preprocess does with each video buffer of a stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <utility>
#include <vector>

#include "core/limit/buffer_limit.hpp"
#include "core/preprocess/boxes.hpp"
#include "gstcpp/allocation.hpp"
#include "gstcpp/ref.hpp"
#include "gstcpp/tensor_meta.hpp"
#include "weir/result.hpp"

namespace weir {

// Of one frame.
struct RegionCounts {
  uint64_t prepared = 0, empty = 0, beyond_limit = 0;
};

class PictureWork {
 public:
  virtual ~PictureWork() = default;
  // How buffers lie in memory from the next one on. LIMIT_EXCEEDED.
  virtual Status allocate_as(const gst::Allocation& allocation) = 0;
  // The part of each picture that counts, from the next one on; none = all of it.
  void set_crop(const std::optional<preprocess::Rect>& crop) { crop_ = crop; }
  // Of the next picture, instead of its metadata.
  virtual void set_boxes(std::vector<preprocess::Box>) {}
  // A buffer for run() to write what is made of `in`; one without memory when that is nothing.
  // OUT_OF_MEMORY, LIMIT_EXCEEDED, or what makes `in` no picture to work on.
  virtual Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) = 0;
  // After acquire() with the same `in`.
  virtual Status run(GstBuffer* in, GstBuffer* out) = 0;
  // For each tensor, or each region, of the last frame; none when nothing was made of it.
  virtual std::vector<PictureMap> ways_back() const = 0;
  virtual gst::MapsOf maps_of() const { return gst::MapsOf::Tensors; }
  virtual RegionCounts regions() const { return {}; }
  virtual uint64_t allocated() const = 0;  // buffers, since the work began
  // Bytes that run() copied to read the picture since the last call.
  uint64_t take_copied() noexcept { return std::exchange(copied_, 0); }

 protected:
  uint64_t copied_ = 0;
  std::optional<preprocess::Rect> crop_;
};

}  // namespace weir
