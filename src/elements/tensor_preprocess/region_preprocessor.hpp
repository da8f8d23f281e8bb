// RegionPreprocessor: converts the regions given by a buffer's metadata or a second stream to one
// batch.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/preprocess/boxes.hpp"
#include "core/preprocess/runner.hpp"
#include "core/tensor/geometry.hpp"
#include "elements/tensor_preprocess/batch_pool.hpp"
#include "elements/tensor_preprocess/picture_work.hpp"
#include "elements/tensor_preprocess/video_picture.hpp"

namespace weir {

inline constexpr uint32_t kRegionLimit = 4096;  // per frame
// The limit of a flexible frame, whose content decides its size: at most the regions that fit, at
// least one.
inline constexpr uint64_t kRegionBytesLimit = uint64_t{1} << 30;

struct RegionOptions {
  uint32_t max = 0;  // of a static tensor, zeros after the last; 0 = a flexible tensor
  bool clip = true;  // otherwise padding fills the area outside the picture
  preprocess::RegionShape shape = {};
};

// Uses the boxes of set_boxes() or else each GstVideoRegionOfInterestMeta, in order. Boxes of the
// same picture in another size are scaled. Each is clipped to the picture (or to the crop, in
// pixels of the picture in memory) or padded outside of it, and resized to one index of the
// outermost dimension. Empty regions and those beyond the limit are counted.
class RegionPreprocessor : public PictureWork {
 public:
  // Errors: make_picture(), PreprocessPlan::make(), FramePool::make().
  static Result<std::unique_ptr<RegionPreprocessor>> make(preprocess::Preparation preparation,
                                                          const GstVideoInfo& video,
                                                          const RegionOptions& options,
                                                          size_t threads);

  Status allocate_as(const gst::Allocation& allocation) override {
    return pool_.allocate_as(allocation);
  }
  void set_boxes(preprocess::PictureRegions boxes) override { boxes_ = std::move(boxes); }
  Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) override;
  Status run(GstBuffer* in, GstBuffer* out) override;
  std::vector<SourceMap> source_maps() const override;
  gst::MapsOf maps_of() const override { return gst::MapsOf::Regions; }
  RegionCounts regions() const override { return counts_; }
  uint64_t allocated() const override { return pool_.allocated(); }

 private:
  RegionPreprocessor(const GstVideoInfo& video, preprocess::PreprocessPlan whole,
                     const RegionOptions& options, BatchPool pool, size_t threads);
  Status adapt(const CroppedPicture& size);
  void find_regions(GstBuffer* in, Size memory, const Rect& picture);
  preprocess::PictureScale find_scale(Size memory);
  Status make_plans();
  size_t region_bytes() const noexcept { return *whole_.preparation().tensor().bytes(); }

  GstVideoInfo video_;
  preprocess::PreprocessPlan whole_;  // without a crop
  RegionOptions options_;
  std::optional<preprocess::PictureRegions> boxes_;
  bool has_warned_ = false;
  BatchPool pool_;
  preprocess::Runner runner_;
  RegionCounts counts_;
  // The current frame's regions; reused. Each index keeps its plan, which adapts to each frame's
  // region.
  Rect picture_;
  std::vector<preprocess::Roi> regions_;
  std::vector<preprocess::PreprocessPlan> plans_;
  std::vector<preprocess::Job> jobs_;
};

}  // namespace weir
