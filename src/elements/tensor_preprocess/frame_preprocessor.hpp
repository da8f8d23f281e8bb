// FramePreprocessor: video buffers of one stream in, tensor buffers out.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/preprocess/runner.hpp"
#include "elements/tensor_preprocess/picture_work.hpp"
#include "elements/tensor_preprocess/video_picture.hpp"
#include "gstcpp/frame_pool.hpp"

namespace weir {

class FramePreprocessor : public PictureWork {
 public:
  // One tensor for each preparation; their source is what `video` says. Errors: picture_of(),
  // Plan::make(), FramePool::make().
  static Result<std::unique_ptr<FramePreprocessor>> make(
      std::vector<preprocess::Preparation> preparations, const GstVideoInfo& video, size_t threads);

  Status allocate_as(const gst::Allocation& allocation) override;
  Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) override;
  // Errors: MappedPicture::map(), Plan::make() for the crop, Plan::run_rows().
  Status run(GstBuffer* in, GstBuffer* out) override;
  std::vector<PictureMap> ways_back() const override;
  uint64_t allocated() const override { return allocated_before_ + pool_.stats().allocated; }

 private:
  FramePreprocessor(const GstVideoInfo& video, std::vector<preprocess::Plan> plans,
                    gst::FramePool pool, size_t threads);
  Status adapt(GstBuffer* in);

  GstVideoInfo video_;
  PictureSize size_;  // of the plans' picture
  // A layer of a pyramid is made from the picture, also where it is half of the layer before or
  // less and could be made from that. Bilinear from a layer is another formula than from the
  // picture; the mean of means is the mean only where the sizes divide, and not of rounded bytes;
  // normalised or quantised numbers are no pixels to go on from. It would read less: area reads
  // the whole picture for each layer.
  std::vector<preprocess::Plan> plans_;
  std::vector<preprocess::Job> jobs_;  // of the frame in work; keeps its memory
  preprocess::Runner runner_;
  gst::Allocation allocation_;
  gst::FramePool pool_;
  uint64_t allocated_before_ = 0;  // by pools that are no more
  gst::FramePool::Writer writer_;
};

}  // namespace weir
