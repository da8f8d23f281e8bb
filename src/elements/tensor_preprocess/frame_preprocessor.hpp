// FramePreprocessor: video buffers of one stream in, tensor buffers out.
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

  Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in) override;
  // Errors: MappedPicture::map(), Plan::make() for the crop, Plan::run_rows().
  Status run(GstBuffer* in, GstBuffer* out) override;
  std::vector<PictureMap> ways_back() const override;
  uint64_t allocated() const override { return pool_.stats().allocated; }

 private:
  FramePreprocessor(const GstVideoInfo& video, std::vector<preprocess::Plan> plans,
                    gst::FramePool pool, size_t threads);
  Status adapt(GstBuffer* in);

  GstVideoInfo video_;
  PictureSize size_;  // of the plans' picture
  // A layer of a pyramid is made from the picture, not from the layer before, though that would
  // read less: its numbers are then those of the single picture, and rows of normalised or
  // quantised numbers are no pixels to go on from.
  std::vector<preprocess::Plan> plans_;
  std::vector<preprocess::Job> jobs_;  // of the frame in work; keeps its memory
  preprocess::Runner runner_;
  gst::FramePool pool_;
  gst::FramePool::Writer writer_;
};

}  // namespace weir
