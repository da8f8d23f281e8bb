// FramePreprocessor: converts the video buffers of a stream to tensor buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/preprocess/runner.hpp"
#include "elements/tensor_preprocess/picture_work.hpp"
#include "elements/tensor_preprocess/video_picture.hpp"
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir {

class FramePreprocessor : public PictureWork {
 public:
  // One tensor per preparation; `video` describes the source. Errors: make_picture(),
  // PreprocessPlan::make(), FramePool::make().
  static Result<std::unique_ptr<FramePreprocessor>> make(
      std::vector<preprocess::Preparation> preparations, const GstVideoInfo& video, size_t threads);

  Status allocate_as(const gst::Allocation& allocation) override;
  Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) override;
  // Errors: MappedPicture::map(), PreprocessPlan::make() for the crop, PreprocessPlan::run_rows().
  Status run(GstBuffer* in, GstBuffer* out) override;
  std::vector<SourceMap> source_maps() const override;
  uint64_t allocated() const override { return allocated_before_ + pool_.stats().allocated; }

 private:
  FramePreprocessor(const GstVideoInfo& video, std::vector<preprocess::PreprocessPlan> plans,
                    gst::FramePool pool, size_t threads);
  Status adapt(GstBuffer* in);

  GstVideoInfo video_;
  CroppedPicture size_;  // of the picture that the plans fit
  // Every layer of a pyramid is made from the picture, even if the previous layer is at least twice
  // as large. Bilinear from a layer differs from bilinear from the picture; a mean of means is the
  // mean only if the sizes divide evenly and bytes are not rounded; normalised or quantised values
  // are no pixels. The price: area scaling reads the whole picture for each layer.
  std::vector<preprocess::PreprocessPlan> plans_;
  std::vector<preprocess::Job> jobs_;  // of the current frame; reused
  preprocess::Runner runner_;
  gst::Allocation allocation_;
  gst::FramePool pool_;
  uint64_t allocated_before_ = 0;  // by previous pools
  gst::FramePool::Writer writer_;
};

}  // namespace weir
