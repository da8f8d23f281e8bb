// RoiResultsPad: the sink pad for results that become regions of pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/records/record_writer.hpp"
#include "gstcpp/buffer/picture_results.hpp"
#include "gstcpp/pads/paired_tensors.hpp"

namespace weir {

// The results of one frame.
struct RegionResults : gst::PictureResults {
  // The size of the picture that coordinates refer to; 0: the picture that gets the regions.
  uint32_t width = 0, height = 0;
};

class RoiResultsPad final : public gst::PairedTensors<RegionResults> {
 public:
  // Call before a stream starts.
  void start(ResultsSync sync, records::Labels labels, float threshold);
  // Reads the caps of results.
  Status handle(GstEvent* event);
  void add_stats(GstStructure* stats) const;

 private:
  Status accept(const FrameSpec& spec) override;
  // Errors: ResultReader::read().
  Result<Results> read(GstBuffer* buffer, const std::vector<gst::TensorPlace>& tensors) override;
  void set_labels(const records::LabelsBySource& labels) override;
  void add_object(const records::ResultFrame& frame, const records::ResultObject& object,
                  std::vector<int32_t>* region_of, RegionResults* out);
  gst::Segmentation read_class_map(const records::ClassMapView& view,
                                   std::span<const SourceMap> maps) const;
  const records::Labels& labels() const noexcept;

  records::Labels labels_, labels_of_stream_;  // those of the user count, if there are any
  float threshold_ = 0;
  records::ResultReader reader_;
  bool has_columns_ = false;
  records::ResultFrame frame_;
  std::atomic<uint64_t> without_region_{0}, not_finite_{0};
};

}  // namespace weir
