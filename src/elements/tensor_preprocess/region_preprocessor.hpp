// RegionPreprocessor: the regions that a buffer's metadata or a second stream name become one
// batch.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <memory>

#include "core/preprocess/runner.hpp"
#include "elements/tensor_preprocess/batch_pool.hpp"
#include "elements/tensor_preprocess/picture_work.hpp"
#include "elements/tensor_preprocess/video_picture.hpp"

namespace weir {

inline constexpr uint32_t kRegionLimit = 4096;  // in a frame
// Of a flexible frame, whose size the stream says: no more regions than fit, but one.
inline constexpr uint64_t kRegionBytesLimit = uint64_t{1} << 30;

struct RegionOptions {
  uint32_t most = 0;  // in a static tensor, zeros behind the last; 0 = a flexible tensor
  bool clip = true;   // else padding stands for what is outside of the picture
};

// Each box that set_boxes() brought for the frame, or else each GstVideoRegionOfInterestMeta, in
// their order, is clipped to the picture (to the crop where
// there is one, in pixels of the picture in memory) or padded outside of it, cut and resized to one
// index of the outermost dimension. What shows nothing, and what is beyond the limit, is counted.
class RegionPreprocessor : public PictureWork {
 public:
  // Errors: picture_of(), Plan::make(), FramePool::make().
  static Result<std::unique_ptr<RegionPreprocessor>> make(preprocess::Preparation preparation,
                                                          const GstVideoInfo& video,
                                                          const RegionOptions& options,
                                                          size_t threads);

  Status allocate_as(const gst::Allocation& allocation) override {
    return pool_.allocate_as(allocation);
  }
  void set_boxes(std::vector<preprocess::Box> boxes) override { boxes_ = std::move(boxes); }
  Result<gst::Ref<GstBuffer>> acquire(GstBuffer* in, const BufferLimit& limit) override;
  Status run(GstBuffer* in, GstBuffer* out) override;
  std::vector<PictureMap> ways_back() const override;
  gst::MapsOf maps_of() const override { return gst::MapsOf::Regions; }
  RegionCounts regions() const override { return counts_; }
  uint64_t allocated() const override { return pool_.allocated(); }

 private:
  RegionPreprocessor(const GstVideoInfo& video, preprocess::Plan whole,
                     const RegionOptions& options, BatchPool pool, size_t threads);
  Status adapt(const PictureSize& size);
  void find_regions(GstBuffer* in, const preprocess::Rect& picture);
  Status make_plans();
  size_t region_bytes() const noexcept { return *whole_.preparation().tensor().bytes(); }

  GstVideoInfo video_;
  preprocess::Plan whole_;  // without a crop
  RegionOptions options_;
  std::optional<std::vector<preprocess::Box>> boxes_;
  BatchPool pool_;
  preprocess::Runner runner_;
  RegionCounts counts_;
  // Of the frame in work; they keep their memory. A plan stays for each index and is laid anew on
  // each frame's region.
  preprocess::Rect picture_;
  std::vector<preprocess::Box> regions_;
  std::vector<preprocess::Plan> plans_;
  std::vector<preprocess::Job> jobs_;
};

}  // namespace weir
