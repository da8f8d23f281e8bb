// FramePreprocessor: video buffers of one stream in, tensor buffers out.
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/preprocess/runner.hpp"
#include "elements/tensor_preprocess/video_picture.hpp"
#include "gstcpp/frame_pool.hpp"

namespace weir {

class FramePreprocessor {
 public:
  // The source of `preparation` is what `video` says. Errors: picture_of(), Plan::make().
  static Result<std::unique_ptr<FramePreprocessor>> make(preprocess::Preparation preparation,
                                                         const GstVideoInfo& video, size_t threads);

  // A buffer for run() to write; null when memory ran out.
  gst::Ref<GstBuffer> acquire() { return pool_.acquire(); }
  // Errors: MappedPicture::map(), Plan::make() for the crop, Plan::run_rows().
  Status run(GstBuffer* in, GstBuffer* out);
  // Of the last frame, and before the first as the caps say.
  PictureMap way_back() const noexcept {
    return preprocess::way_back(runner_.plan().preparation());
  }
  gst::FramePoolStats pool_stats() const { return pool_.stats(); }

 private:
  FramePreprocessor(const GstVideoInfo& video, preprocess::Plan plan, gst::FramePool pool,
                    size_t threads);
  Status adapt(GstBuffer* in);

  GstVideoInfo video_;
  PictureSize size_;  // of the plan's picture
  preprocess::Runner runner_;
  gst::FramePool pool_;
  gst::FramePool::Writer writer_;
};

}  // namespace weir
