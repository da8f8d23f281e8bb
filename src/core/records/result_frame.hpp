// Reads a frame of results (weir/results.h) as a list of objects, with every tensor's bounds
// checked.
//
//   auto reader = ResultReader::make(columns, sources);
//   ResultFrame frame;
//   if (reader && reader->read(tensors, &frame))
//     for (const ResultObject& object : frame.objects) use(object);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/records/zone_columns.hpp"
#include "core/results/frame_results.hpp"
#include "core/tensor/frame_spec.hpp"
#include "weir/results.h"
#include "weir/source_map.hpp"

namespace weir::records {

// A tensor of the frame; borrowed. The bytes may have any alignment.
struct ResultTensor {
  TensorSpec spec;
  std::span<const std::byte> bytes;
};

inline constexpr uint32_t kNoTensor = UINT32_MAX;

// What the rows of a tensor are: boxes, labels of a picture or region, or texts.
enum class RowKind { Detection, Label, Text };

// The rows of one tensor, and the tables that follow it.
struct RowGroup {
  weir_result_columns columns{};
  uint32_t source = 0;                                             // in ResultReader::sources()
  uint32_t rows = kNoTensor, masks = kNoTensor, text = kNoTensor;  // indices of tensors
  ZoneColumns zones{};

  RowKind kind() const noexcept {
    if (text != kNoTensor) return RowKind::Text;
    return columns.box >= 0 ? RowKind::Detection : RowKind::Label;
  }
};

// Probabilities 0 to 255 over a box, row after row; borrowed from the frame's tensors.
struct MaskView {
  uint32_t width = 0, height = 0;
  std::span<const std::byte> values;
};

// A row that is not background. Its numbers are finite.
struct ResultObject {
  uint32_t group = 0;  // in ResultReader::groups()
  bool has_box = false;
  Box box{};
  float score = 1;
  int32_t class_index = -1;  // -1 = no class
  uint32_t track = 0;        // 0 = none
  int32_t parent = -1;       // index in ResultFrame::objects; -1 = none
  float rotation = 0;
  uint32_t first_point = 0, n_points = 0;  // in ResultFrame::points
  MaskView mask{};
  std::string_view text{};                // of groups of texts; may be invalid UTF-8
  float speed = NAN, ground_speed = NAN;  // pixels and metres a second; NaN = not known
  uint32_t first_zone = 0, n_zones = 0;   // in ResultFrame::zones
};

// An area in which an object is.
struct ObjectZone {
  uint32_t zone = 0;  // its name is number `zone` in the names of zones
  float dwell = NAN;  // seconds; NaN = not known
};

// What was counted in a zone, for one class or in total. NaN = does not apply or is not known.
struct ZoneCount {
  uint32_t zone = 0;
  int32_t class_index = -1;  // -1 = all
  float inside = NAN, entered = NAN, left = NAN, forward = NAN, backward = NAN;
  float speed = NAN, ground_speed = NAN;  // mean of the objects inside
};

struct ZoneEvent {
  uint32_t zone = 0;
  uint32_t kind = 0;         // the number of a zone::EventKind
  int32_t class_index = -1;  // -1 = not known
  uint32_t track = 0;
  float dwell = NAN, speed = NAN, ground_speed = NAN;
};

// The class of each pixel of the picture; borrowed.
struct ClassMapView {
  uint32_t source = 0, tensor = 0;
  uint32_t width = 0, height = 0;
  bool is_wide = false;  // uint16, else uint8
  std::span<const std::byte> values;

  uint32_t at(size_t index) const noexcept;
};

// The depth of each pixel of the picture; borrowed.
struct DepthView {
  uint32_t source = 0, tensor = 0;
  uint32_t width = 0, height = 0;
  std::span<const std::byte> values;

  float at(size_t index) const noexcept;
};

struct ResultFrame {
  std::vector<ResultObject> objects;
  std::vector<results::KeyPoint> points;  // not finite: the point was not found
  std::vector<ClassMapView> class_maps;
  std::vector<DepthView> depths;
  std::vector<ObjectZone> zones;  // of the objects
  std::vector<ZoneCount> zone_counts;
  std::vector<ZoneEvent> zone_events;
  uint64_t rows_not_finite = 0;  // that were left out

  void clear() noexcept;  // keeps the memory
};

class ResultReader {
 public:
  // The texts of weir-columns and weir-source. Without columns (""), a frame has one tensor of rows
  // as weir/detection.hpp defines them. OPTION_SYNTAX: columns that are not valid, a table without
  // rows before it.
  static Result<ResultReader> make(const std::string& columns, const std::string& sources);

  // SPEC_MISMATCH for tensors that are not what the columns say.
  Status check(std::span<const TensorSpec> specs) const;
  // The same for one frame, and FRAME_SIZE for a tensor with fewer bytes than its shape. `out`
  // borrows the tensors.
  Status read(std::span<const ResultTensor> tensors, ResultFrame* out) const;

  const std::vector<RowGroup>& groups() const noexcept { return groups_; }
  // Names of what made the tensors, each once, in the order of the tensors.
  const std::vector<std::string>& sources() const noexcept { return sources_; }
  // Whether frames have counts and events of zones, and the source of their names.
  bool has_zones() const noexcept { return has_zones_; }
  const std::string& zone_source() const noexcept { return zone_source_; }

 private:
  enum class ZoneTable { None, Counts, Events };
  // Adds the next tensor. Returns what is wrong with its entry; null if nothing is.
  const char* add(const std::string& entry, const std::string& source);
  const char* add_zone_table(ZoneTable table, const std::string& source);
  const char* add_to_groups(const weir_result_columns& columns, const std::string& entry,
                            uint32_t index);
  Status check(size_t index, const TensorSpec& spec) const;
  Status check_groups(std::span<const TensorSpec> specs) const;
  void read_maps(std::span<const TensorSpec> specs, std::span<const ResultTensor> tensors,
                 ResultFrame* out) const;
  RowGroup plain_group(const TensorSpec& spec) const;
  void read_zones(uint32_t tensor, const ResultTensor& rows, ResultFrame* out) const;

  bool has_columns_ = false;
  std::vector<weir_result_columns> columns_;  // of each tensor
  std::vector<uint32_t> source_of_;           // likewise
  std::vector<ZoneTable> zone_tables_;        // likewise
  bool has_zones_ = false;
  std::string zone_source_;
  std::vector<RowGroup> groups_;
  std::vector<std::string> sources_;
};

}  // namespace weir::records
