// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/frame_preprocessor.hpp"

#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {

using preprocess::Preparation;
using preprocess::PreprocessPlan;

FramePreprocessor::FramePreprocessor(const GstVideoInfo& video, std::vector<PreprocessPlan> plans,
                                     gst::FramePool pool, size_t threads)
    : video_(video),
      size_{plans[0].preparation().source.width, plans[0].preparation().source.height, {}},
      plans_(std::move(plans)),
      runner_(threads),
      pool_(std::move(pool)) {}

Result<std::unique_ptr<FramePreprocessor>> FramePreprocessor::make(
    std::vector<Preparation> preparations, const GstVideoInfo& video, size_t threads) {
  auto picture = make_picture(video);
  if (!picture) return picture.error();
  std::vector<TensorSpec> tensors;
  std::vector<PreprocessPlan> plans;
  for (Preparation& preparation : preparations) {
    preparation.source = *picture;
    tensors.push_back(preparation.tensor());
    auto plan = PreprocessPlan::make(std::move(preparation));
    if (!plan) return plan.error();
    plans.push_back(*std::move(plan));
  }
  auto pool = gst::FramePool::make(std::move(tensors), Format::Static);
  if (!pool) return pool.error();
  return std::unique_ptr<FramePreprocessor>(
      new FramePreprocessor(video, std::move(plans), *std::move(pool), threads));
}

Status FramePreprocessor::allocate_as(const gst::Allocation& allocation) {
  if (allocation == allocation_) return ok();
  auto pool = gst::FramePool::make(pool_.tensors(), Format::Static, MediaType::Tensor, allocation);
  if (!pool) return pool.error();
  allocated_before_ += pool_.stats().allocated;
  allocation_ = allocation;
  pool_ = *std::move(pool);
  return ok();
}

Result<gst::Ref<GstBuffer>> FramePreprocessor::acquire(GstBuffer*, const BufferLimit& limit) {
  return pool_.acquire(limit);
}

// Remakes the plans for another picture size; an existing plan adapts to another crop.
Status FramePreprocessor::adapt(GstBuffer* in) {
  CroppedPicture size = size_of_picture(video_, in);
  if (auto status = narrow(&size, crop_); !status) return status;
  if (size == size_) return ok();
  if (size.width == size_.width && size.height == size_.height) {
    const Rect whole{0, 0, size.width, size.height};
    for (PreprocessPlan& plan : plans_)
      if (auto status = plan.set_crop(size.crop.value_or(whole)); !status) return status;
    size_ = size;
    return ok();
  }
  std::vector<PreprocessPlan> plans;
  for (const PreprocessPlan& before : plans_) {
    Preparation preparation = before.preparation();
    preparation.source.width = size.width;
    preparation.source.height = size.height;
    preparation.crop = size.crop;
    auto plan = PreprocessPlan::make(std::move(preparation));
    if (!plan) return plan.error();
    plans.push_back(*std::move(plan));
  }
  plans_ = std::move(plans);
  size_ = size;
  return ok();
}

std::vector<SourceMap> FramePreprocessor::source_maps() const {
  std::vector<SourceMap> out;
  for (const PreprocessPlan& plan : plans_)
    out.push_back(preprocess::make_source_map(plan.preparation()));
  return out;
}

Status FramePreprocessor::run(GstBuffer* in, GstBuffer* out) {
  if (auto status = adapt(in); !status) return status;
  MappedPicture picture;
  if (auto status = picture.map(video_, in); !status) return status;
  copied_ += picture.bytes_copied();
  Status status = writer_.map(pool_, out);
  if (status) {
    jobs_.clear();
    for (size_t i = 0; i < plans_.size(); ++i) jobs_.push_back({&plans_[i], writer_.payloads()[i]});
    status = runner_.run(picture.planes(), jobs_);
  }
  writer_.unmap();
  return status;
}

}  // namespace weir
