// RecordWriter: writes frames of results in one text format; each format has its own file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/records/result_frame.hpp"
#include "core/records/source_labels.hpp"

namespace weir::records {

// What a frame says beside its tensors. Times in nanoseconds, -1 = unknown.
struct FrameFacts {
  int64_t running_time = -1, duration = -1;
  int64_t unix_time = -1;          // of the frame's capture, since 1970 UTC
  uint32_t width = 0, height = 0;  // of the source picture; 0 = unknown
  std::vector<SourceMap> maps{};   // one for all tensors, or one for each; empty = unknown
};

// Names of classes, for each source of the results.
class Labels {
 public:
  Labels() = default;
  explicit Labels(std::vector<std::vector<std::string>> of_source)
      : of_source_(std::move(of_source)) {}
  bool empty() const noexcept { return of_source_.empty(); }
  // The label of class `index`, or its number, which `number` then holds.
  std::string_view of(uint32_t source, int32_t index, std::string* number) const;

 private:
  std::vector<std::vector<std::string>> of_source_;
};

// Reads label files, separated by semicolons: for the sources in their order. An entry that is
// empty has no labels. Throws Failure as read_label_file().
Labels read_labels(const std::string& option, const std::string& paths);

struct WriterSettings {
  Labels labels{};
  std::vector<std::string> zones{};  // names of zones
  float threshold = 0;               // least score of what is written
  bool has_masks = false;            // json: masks and class maps
  bool has_coco_ids = false;         // coco: class indices 0 to 79 become the ids 1 to 90 of COCO
};

class RecordWriter {
 public:
  explicit RecordWriter(WriterSettings settings) : settings_(std::move(settings)) {}
  virtual ~RecordWriter() = default;
  // Replaces the names of classes from the next frame on.
  void set_labels(Labels labels) { settings_.labels = std::move(labels); }
  void set_zone_names(std::vector<std::string> names) { settings_.zones = std::move(names); }
  // Appends a frame. Returns false if the format has nothing to write for it.
  virtual bool write(const ResultReader& reader, const ResultFrame& frame, const FrameFacts& facts,
                     std::string* out) = 0;
  // The next frame is the first one of a stream.
  virtual void restart() noexcept {}

 protected:
  WriterSettings settings_;
};

std::unique_ptr<RecordWriter> json_writer(WriterSettings settings);
std::unique_ptr<RecordWriter> webvtt_writer(WriterSettings settings);
std::unique_ptr<RecordWriter> coco_writer(WriterSettings settings);
std::unique_ptr<RecordWriter> mot_writer(WriterSettings settings);

// ---- What the formats share ---------------------------------------------------------------------

// The box of an object: its own, or that of its parent; null if neither has one.
const ResultObject* with_box(const ResultFrame& frame, const ResultObject& object) noexcept;
RowKind get_kind(const ResultReader& reader, const ResultObject& object) noexcept;
// {"size":[height,width],"counts":"..."}
void append_mask(const std::vector<uint32_t>& runs, uint32_t width, uint32_t height,
                 std::string* out);

}  // namespace weir::records
