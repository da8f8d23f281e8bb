// Maps, prepares, unmaps.
#include "elements/tensor_preprocess/frame_preprocessor.hpp"

namespace weir {

using preprocess::Plan;
using preprocess::Preparation;

FramePreprocessor::FramePreprocessor(const GstVideoInfo& video, Plan plan, gst::FramePool pool,
                                     size_t threads)
    : video_(video),
      size_{plan.preparation().source.width, plan.preparation().source.height, {}},
      runner_(std::move(plan), threads),
      pool_(std::move(pool)) {}

Result<std::unique_ptr<FramePreprocessor>> FramePreprocessor::make(Preparation preparation,
                                                                   const GstVideoInfo& video,
                                                                   size_t threads) {
  auto picture = picture_of(video);
  if (!picture) return picture.error();
  preparation.source = *picture;
  auto pool = gst::FramePool::make({preparation.tensor()}, Format::Static);
  if (!pool) return pool.error();
  auto plan = Plan::make(std::move(preparation));
  if (!plan) return plan.error();
  return std::unique_ptr<FramePreprocessor>(
      new FramePreprocessor(video, *std::move(plan), *std::move(pool), threads));
}

// The plan is made again when a buffer's picture has another size or crop.
Status FramePreprocessor::adapt(GstBuffer* in) {
  const PictureSize size = size_of_picture(video_, in);
  if (size == size_) return ok();
  Preparation preparation = runner_.plan().preparation();
  preparation.source.width = size.width;
  preparation.source.height = size.height;
  preparation.crop = size.crop;
  auto plan = Plan::make(std::move(preparation));
  if (!plan) return plan.error();
  runner_.set_plan(*std::move(plan));
  size_ = size;
  return ok();
}

Status FramePreprocessor::run(GstBuffer* in, GstBuffer* out) {
  if (auto status = adapt(in); !status) return status;
  MappedPicture picture;
  if (auto status = picture.map(video_, in); !status) return status;
  Status status = writer_.map(pool_, out);
  if (status) status = runner_.run(picture.planes(), writer_.payloads()[0]);
  writer_.unmap();
  return status;
}

}  // namespace weir
