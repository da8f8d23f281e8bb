// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/region_preprocessor.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/tensor/geometry.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {

using preprocess::Preparation;
using preprocess::PreprocessPlan;

RegionPreprocessor::RegionPreprocessor(const GstVideoInfo& video, PreprocessPlan whole,
                                       const RegionOptions& options, BatchPool pool, size_t threads)
    : video_(video),
      whole_(std::move(whole)),
      options_(options),
      pool_(std::move(pool)),
      runner_(threads) {}

Result<std::unique_ptr<RegionPreprocessor>> RegionPreprocessor::make(Preparation preparation,
                                                                     const GstVideoInfo& video,
                                                                     const RegionOptions& options,
                                                                     size_t threads) {
  auto picture = make_picture(video);
  if (!picture) return picture.error();
  preparation.source = *picture;
  auto pool = BatchPool::make(preparation.tensor(), options.max);
  if (!pool) return pool.error();
  auto plan = PreprocessPlan::make(std::move(preparation));
  if (!plan) return plan.error();
  return std::unique_ptr<RegionPreprocessor>(
      new RegionPreprocessor(video, *std::move(plan), options, *std::move(pool), threads));
}

Status RegionPreprocessor::adapt(const CroppedPicture& size) {
  const preprocess::Picture& source = whole_.preparation().source;
  if (source.width != size.width || source.height != size.height) {
    Preparation preparation = whole_.preparation();
    preparation.source.width = size.width;
    preparation.source.height = size.height;
    auto plan = PreprocessPlan::make(std::move(preparation));
    if (!plan) return plan.error();
    whole_ = *std::move(plan);
    plans_.clear();
  }
  return size.crop ? check_crop(whole_.preparation().source, *size.crop) : ok();
}

// From the picture of the boxes to the one in memory. Boxes of another part of the picture stay.
preprocess::PictureScale RegionPreprocessor::find_scale(Size memory) {
  const Size from = boxes_->picture;
  const double pixel_aspect =
      static_cast<double>(GST_VIDEO_INFO_PAR_N(&video_)) / GST_VIDEO_INFO_PAR_D(&video_);
  if (const auto scale = preprocess::find_scale(from, memory, pixel_aspect)) return *scale;
  if (!std::exchange(has_warned_, true)) warning_ = preprocess::boxes_of_another_view(from, memory);
  return {};
}

void RegionPreprocessor::find_regions(GstBuffer* in, Size memory, const Rect& picture) {
  const uint64_t fitting = std::max<uint64_t>(kRegionBytesLimit / region_bytes(), 1);
  const uint64_t max = options_.max > 0 ? options_.max : std::min<uint64_t>(fitting, kRegionLimit);
  picture_ = picture;
  regions_.clear();
  counts_ = {};
  const auto shows_nothing = [&](const preprocess::Roi& box) {
    if (!options_.clip) return !preprocess::check_region(whole_.preparation(), picture, box);
    const Rect part = preprocess::common_part(picture, box);
    return part.width == 0 || part.height == 0;
  };
  const auto add = [&](const preprocess::Roi& box) {
    if (shows_nothing(box))
      ++counts_.empty;
    else if (regions_.size() == max)
      ++counts_.beyond_limit;
    else
      regions_.push_back(box);
  };
  if (boxes_) {
    const auto scale = find_scale(memory);
    for (const auto& box : boxes_->boxes) add(preprocess::make_region(box, options_.shape, scale));
  } else {
    gpointer state = nullptr;
    uint64_t row = 0;  // as tensor_from_roi counts them
    while (const GstMeta* meta = gst_buffer_iterate_meta_filtered(
               in, &state, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)) {
      const auto* region = reinterpret_cast<const GstVideoRegionOfInterestMeta*>(meta);
      const double x = region->x, y = region->y;
      add(preprocess::make_region(
          {.left = x, .top = y, .right = x + region->w, .bottom = y + region->h, .row = ++row},
          options_.shape));
    }
  }
  counts_.prepared = regions_.size();
}

Status RegionPreprocessor::make_plans() {
  while (plans_.size() < regions_.size()) plans_.push_back(whole_);
  for (size_t i = 0; i < regions_.size(); ++i) {
    Status status = options_.clip
                        ? plans_[i].set_crop(preprocess::common_part(picture_, regions_[i]))
                        : plans_[i].set_region(picture_, regions_[i]);
    if (!status) return status;
  }
  return ok();
}

Result<gst::Ref<GstBuffer>> RegionPreprocessor::acquire(GstBuffer* in, const BufferLimit& limit) {
  CroppedPicture size = size_of_picture(video_, in);
  if (auto status = narrow(&size, crop_); !status) return status.error();
  if (auto status = adapt(size); !status) return status.error();
  find_regions(in, {size.width, size.height},
               size.crop.value_or(Rect{0, 0, size.width, size.height}));
  if (regions_.empty()) return gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  return pool_.acquire(regions_.size(), limit);
}

Status RegionPreprocessor::run(GstBuffer* in, GstBuffer* out) {
  if (regions_.empty()) return ok();
  if (auto status = make_plans(); !status) return status;
  MappedPicture picture;
  if (auto status = picture.map(video_, in); !status) return status;
  copied_ += picture.bytes_copied();
  const gst::MappedMemory map(gst_buffer_peek_memory(out, 0), GST_MAP_WRITE);
  if (!map) return gst::output_not_writable();
  std::span<std::byte> bytes = map.bytes();
  if (options_.max == 0) bytes = bytes.subspan(kTensorHeaderBytes);
  jobs_.clear();
  for (size_t i = 0; i < regions_.size(); ++i) {
    jobs_.push_back({&plans_[i], bytes.first(region_bytes())});
    bytes = bytes.subspan(region_bytes());
  }
  if (!bytes.empty()) std::memset(bytes.data(), 0, bytes.size());
  return runner_.run(picture.planes(), jobs_);
}

std::vector<SourceMap> RegionPreprocessor::source_maps() const {
  std::vector<SourceMap> out;
  for (size_t i = 0; i < regions_.size(); ++i) {
    out.push_back(preprocess::make_source_map(plans_[i].preparation()));
    out.back().row = regions_[i].row;
  }
  return out;
}

}  // namespace weir
