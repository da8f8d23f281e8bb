// PictureWork: the work of tensor_preprocess on each video buffer of a stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>
#include <utility>
#include <vector>

#include "core/limit/buffer_limit.hpp"
#include "core/preprocess/boxes.hpp"
#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {

// Counts of one frame.
struct RegionCounts {
  uint64_t prepared = 0, empty = 0, beyond_limit = 0;
};

class PictureWork {
 public:
  virtual ~PictureWork() = default;
  // Sets the allocation of the following buffers. LIMIT_EXCEEDED.
  virtual Status allocate_as(const gst::Allocation& allocation) = 0;
  // Sets the part of the following pictures that is used; nullopt = the whole picture.
  void set_crop(const std::optional<Rect>& crop) { crop_ = crop; }
  // Sets the boxes of the next picture, replacing those of its metadata.
  virtual void set_boxes(preprocess::PictureRegions) {}
  // Returns a buffer for the output of run(); without memory if `in` has no output. OUT_OF_MEMORY,
  // LIMIT_EXCEEDED, or the error of an invalid `in`.
  virtual Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) = 0;
  // Call after acquire() with the same `in`.
  virtual Status run(GstBuffer* in, GstBuffer* out) = 0;
  // The source map of each tensor, or each region, of the last frame; empty if it had no output.
  virtual std::vector<SourceMap> source_maps() const = 0;
  virtual gst::MapsOf maps_of() const { return gst::MapsOf::Tensors; }
  virtual RegionCounts regions() const { return {}; }
  virtual uint64_t allocated() const = 0;  // buffers so far
  // Bytes copied since the last call to read pictures.
  uint64_t take_copied() noexcept { return std::exchange(copied_, 0); }
  // What is wrong with the last frame, if anything that was not reported before.
  std::optional<Error> next_warning() { return std::exchange(warning_, std::nullopt); }

 protected:
  uint64_t copied_ = 0;
  std::optional<Error> warning_;
  std::optional<Rect> crop_;
};

}  // namespace weir
