// ResultsPad: the sink pad for result tensors that are drawn on pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>

#include "core/draw/detections.hpp"
#include "core/records/result_frame.hpp"
#include "gstcpp/pads/paired_tensors.hpp"

namespace weir {

enum class Coordinates : int32_t { Picture, Tensor };

class ResultsPad final : public gst::PairedTensors<draw::Detections> {
 public:
  // Call before a stream starts.
  void start(ResultsSync sync, Coordinates coordinates);
  void add_stats(GstStructure* stats) const;

 private:
  Status accept(const FrameSpec& spec) override;
  // Errors: check_detections(), read_detections(); SPEC_MISMATCH for frames of several tensors, and
  // for frames without a required source map.
  Result<Results> read(GstBuffer* buffer, const std::vector<gst::TensorPlace>& tensors) override;
  Result<Results> read_columns(GstBuffer* buffer, const std::vector<gst::TensorPlace>& tensors);
  void set_labels(const records::LabelsBySource& labels) override;
  void set_zones(const gst::ZonesOfSource& zones) override;
  void count(const draw::LeftOut& left_out);

  bool has_columns_ = false;  // the fields below are of streams with weir-columns
  records::ResultReader reader_;
  records::ResultFrame frame_;
  std::shared_ptr<const draw::ClassNames> names_;  // of the stream; null: it has none
  std::string zone_source_;
  std::shared_ptr<const zone::ZoneSet> zones_;  // of zone_source_; null: there are none

  std::atomic<Coordinates> coordinates_{Coordinates::Picture};
  std::atomic<uint64_t> background_{0}, not_finite_{0}, without_area_{0}, beyond_limit_{0};
  std::atomic<uint64_t> points_not_finite_{0};
};

}  // namespace weir
