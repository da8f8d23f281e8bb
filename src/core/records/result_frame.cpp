// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/result_frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/draw/detections.hpp"
#include "weir/results.hpp"

namespace weir::records {
namespace {

Error bad_columns(const std::string& columns, size_t tensor, std::string what) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = std::move(what),
               .offered = "weir-columns=\"" + columns + "\"",
               .needed = "columns as docs/results.md defines them",
               .difference = "the entry of tensor " + std::to_string(tensor),
               .fix = "weir-columns=\"x1,y1,x2,y2,score,class\""};
}

Error bad_tensor(size_t tensor, const TensorSpec& spec, std::string needed) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "a tensor of results does not match weir-columns",
               .offered = spec.to_string(),
               .needed = std::move(needed),
               .difference = "tensor " + std::to_string(tensor)};
}

// The extent of dimension `i`; dimensions beyond the rank are 1.
uint32_t extent(const Shape& shape, size_t i) {
  return i < shape.rank() ? shape[i] : 1;
}

// Whether all dimensions from `rank` on are 1.
bool is_flat(const Shape& shape, size_t rank) {
  for (size_t i = rank; i < shape.rank(); ++i)
    if (shape[i] != 1) return false;
  return shape.valid();
}

std::vector<std::string> split_entries(const std::string& text) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(';', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

// The columns of rows as weir/detection.hpp defines them, of `length` numbers.
weir_result_columns plain_columns(uint32_t length) {
  std::string text = "x1,y1,x2,y2";
  if (length > 4) text += ",score";
  if (length > 5) text += ",class";
  if (length > 6) text += ",xy:" + std::to_string((length - 6) / 2);
  weir_result_columns out;
  weir_results_parse(text.c_str(), 0, &out);
  return out;
}

// The zone that a number of a column means: they count from 1, 0 is none.
std::optional<uint32_t> to_zone(float number) {
  constexpr float kEnd = 1e6f;
  if (!(number >= 1 && number < kEnd)) return std::nullopt;
  return static_cast<uint32_t>(number) - 1;
}

// Its edges and sides.
bool is_finite(const Box& box) {
  return std::isfinite(box.x1) && std::isfinite(box.y1) && std::isfinite(box.width()) &&
         std::isfinite(box.height());
}

// The numbers of a row, or false if one of box and score is not finite.
bool read_row(const ResultRow& row, const weir_result_columns& columns, ResultObject* out) {
  out->has_box = row.has_box();
  if (out->has_box) out->box = row.box();
  out->score = row.score();
  if (!std::isfinite(out->score) || !is_finite(out->box)) return false;
  out->class_index = columns.class_index >= 0 ? std::max(row.class_index(), -1) : -1;
  out->track = row.track();
  out->rotation = std::isfinite(row.rotation()) ? row.rotation() : 0;
  return true;
}

// The text of row `row`, up to its first zero.
std::string_view read_text(const ResultTensor& tensor, uint32_t row) {
  const size_t length = extent(tensor.spec.shape, 0);
  const std::string_view all(reinterpret_cast<const char*>(tensor.bytes.data()) + row * length,
                             length);
  return all.substr(0, all.find('\0'));
}

MaskView get_mask(const ResultTensor& tensor, uint32_t row) {
  const Shape& shape = tensor.spec.shape;
  MaskView out{extent(shape, 0), extent(shape, 1), {}};
  const size_t bytes = size_t{out.width} * out.height;
  out.values = tensor.bytes.subspan(row * bytes, bytes);
  return out;
}

// Reads the rows of one group after another, and then what refers to rows by number.
class RowReader {
 public:
  RowReader(std::span<const ResultTensor> tensors, ResultFrame* out)
      : tensors_(tensors), out_(*out) {}

  void read(const RowGroup& group, uint32_t number) {
    const ResultTensor& rows = tensors_[group.rows];
    const uint32_t count = extent(rows.spec.shape, 1);
    const size_t row_bytes = group.columns.length * sizeof(float);
    numbers_.resize(group.columns.length);
    for (uint32_t i = 0; i < count; ++i) {
      std::memcpy(numbers_.data(), rows.bytes.data() + i * row_bytes, row_bytes);
      const ResultRow row(group.columns, numbers_.data());
      object_of_row_.push_back(-1);
      if (row.is_background()) continue;
      ResultObject object;
      object.group = number;
      if (!read_row(row, group.columns, &object)) {
        ++out_.rows_not_finite;
        continue;
      }
      add_points(row, &object);
      if (group.masks != kNoTensor) object.mask = get_mask(tensors_[group.masks], i);
      if (group.text != kNoTensor) object.text = read_text(tensors_[group.text], i);
      object.parent = row.parent();  // a row, until end()
      if (group.zones.any()) add_zones(group.zones, &object);
      object_of_row_.back() = static_cast<int32_t>(out_.objects.size());
      out_.objects.push_back(object);
    }
  }

  // Counts rows that are not objects.
  void skip(uint32_t rows) { object_of_row_.insert(object_of_row_.end(), rows, -1); }

  void end() {
    for (size_t i = 0; i < out_.objects.size(); ++i) {
      int32_t& parent = out_.objects[i].parent;
      const bool exists = parent >= 0 && static_cast<size_t>(parent) < object_of_row_.size();
      parent = exists ? object_of_row_[static_cast<size_t>(parent)] : -1;
      if (parent == static_cast<int32_t>(i)) parent = -1;
    }
  }

 private:
  void add_points(const ResultRow& row, ResultObject* object) {
    object->first_point = static_cast<uint32_t>(out_.points.size());
    object->n_points = row.n_points();
    for (uint32_t p = 0; p < row.n_points(); ++p)
      out_.points.push_back({row.x(p), row.y(p), row.point_score(p)});
  }

  void add_zones(const ZoneColumns& columns, ResultObject* object) {
    const auto number = [this](int32_t index) { return numbers_[static_cast<size_t>(index)]; };
    object->speed = number(columns.speed.first);
    if (columns.ground_speed.first >= 0) object->ground_speed = number(columns.ground_speed.first);
    object->first_zone = static_cast<uint32_t>(out_.zones.size());
    for (uint32_t i = 0; i < columns.zone.count; ++i)
      if (const auto zone = to_zone(number(columns.zone.first + static_cast<int32_t>(i))))
        out_.zones.push_back({*zone, number(columns.dwell.first + static_cast<int32_t>(i))});
    object->n_zones = static_cast<uint32_t>(out_.zones.size()) - object->first_zone;
  }

  std::span<const ResultTensor> tensors_;
  ResultFrame& out_;
  std::vector<float> numbers_;
  std::vector<int32_t> object_of_row_;  // index of each row's object; -1 = background
};

}  // namespace

uint32_t ClassMapView::at(size_t index) const noexcept {
  if (!is_wide) return static_cast<uint32_t>(values[index]);
  uint16_t out = 0;
  std::memcpy(&out, values.data() + index * sizeof out, sizeof out);
  return out;
}

float DepthView::at(size_t index) const noexcept {
  float out = 0;
  std::memcpy(&out, values.data() + index * sizeof out, sizeof out);
  return out;
}

void ResultFrame::clear() noexcept {
  objects.clear();
  points.clear();
  class_maps.clear();
  depths.clear();
  zones.clear();
  zone_counts.clear();
  zone_events.clear();
  rows_not_finite = 0;
}

Result<ResultReader> ResultReader::make(const std::string& columns, const std::string& sources) {
  ResultReader out;
  out.has_columns_ = !columns.empty();
  const auto entries = split_entries(columns), names = split_entries(sources);
  if (entries.size() > kTensorLimit)
    return bad_columns(columns, kTensorLimit, "weir-columns names more tensors than a frame has");
  for (uint32_t i = 0; i < entries.size(); ++i) {
    const char* const fault = out.add(entries[i], i < names.size() ? names[i] : std::string());
    if (fault) return bad_columns(columns, i, fault);
  }
  // The columns follow from the first frame's row length.
  if (!out.has_columns_) out.groups_.push_back({.columns = plain_columns(6), .rows = 0});
  return out;
}

const char* ResultReader::add(const std::string& entry, const std::string& source) {
  const auto index = static_cast<uint32_t>(columns_.size());
  weir_result_columns parsed;
  if (!weir_results_parse(entry.c_str(), 0, &parsed))
    return "the columns of a stream of results cannot be read";
  columns_.push_back(parsed);
  const ZoneTable table = entry == kZoneCountColumns   ? ZoneTable::Counts
                          : entry == kZoneEventColumns ? ZoneTable::Events
                                                       : ZoneTable::None;
  if (table != ZoneTable::None) return add_zone_table(table, source);
  zone_tables_.push_back(table);
  auto known = std::find(sources_.begin(), sources_.end(), source);
  if (known == sources_.end() && (parsed.kind != WEIR_RESULT_NONE || !has_columns_))
    known = sources_.insert(known, source);
  source_of_.push_back(static_cast<uint32_t>(known - sources_.begin()));
  return add_to_groups(parsed, entry, index);
}

const char* ResultReader::add_zone_table(ZoneTable table, const std::string& source) {
  if (std::count(zone_tables_.begin(), zone_tables_.end(), table) > 0)
    return "the results have zones of more than one tensor_zones";
  zone_tables_.push_back(table);
  source_of_.push_back(0);
  has_zones_ = true;
  zone_source_ = source;
  return nullptr;
}

const char* ResultReader::add_to_groups(const weir_result_columns& columns,
                                        const std::string& entry, uint32_t index) {
  switch (columns.kind) {
    case WEIR_RESULT_ROWS:
      groups_.push_back({.columns = columns,
                         .source = source_of_.back(),
                         .rows = index,
                         .zones = zone_columns(entry)});
      return nullptr;
    case WEIR_RESULT_MASKS:
    case WEIR_RESULT_SCORES:
    case WEIR_RESULT_TEXT:
      if (groups_.empty()) return "a table of results has no rows before it";
      if (columns.kind == WEIR_RESULT_MASKS) groups_.back().masks = index;
      if (columns.kind == WEIR_RESULT_TEXT) groups_.back().text = index;
      return nullptr;
    default:
      return nullptr;
  }
}

Status ResultReader::check(size_t index, const TensorSpec& spec) const {
  const weir_result_columns& columns = columns_[index];
  const Shape& shape = spec.shape;
  const auto needs = [&](bool fits, ElementType type, const std::string& needed) {
    return fits && spec.type == type ? ok() : Status(bad_tensor(index, spec, needed));
  };
  switch (columns.kind) {
    case WEIR_RESULT_ROWS:
      return needs(is_flat(shape, 2) && shape[0] == columns.length, ElementType::Float32,
                   "float32 " + std::to_string(columns.length) + ":N, rows of the columns");
    case WEIR_RESULT_MASKS:
      return needs(is_flat(shape, 3), ElementType::UInt8, "uint8 W:H:N, a mask for each row");
    case WEIR_RESULT_SCORES:
      return needs(is_flat(shape, 2), ElementType::Float32, "float32 C:N, scores for each row");
    case WEIR_RESULT_TEXT:
      return needs(is_flat(shape, 2), ElementType::UInt8, "uint8 L:N, a text for each row");
    case WEIR_RESULT_DEPTH:
      return needs(is_flat(shape, 2), ElementType::Float32, "float32 W:H, the depth of each pixel");
    case WEIR_RESULT_CLASS_MAP:
      return needs(is_flat(shape, 2),
                   spec.type == ElementType::UInt8 ? ElementType::UInt8 : ElementType::UInt16,
                   "uint8 or uint16 W:H, the class of each pixel");
    default:
      return ok();
  }
}

// Tables have an entry for each row.
Status ResultReader::check_groups(std::span<const TensorSpec> specs) const {
  const RowGroup* group = nullptr;
  size_t next = 0;
  for (size_t i = 0; i < columns_.size(); ++i) {
    const uint32_t kind = columns_[i].kind;
    if (kind == WEIR_RESULT_ROWS && zone_tables_[i] == ZoneTable::None) group = &groups_[next++];
    const size_t of_rows = kind == WEIR_RESULT_MASKS                                ? 2
                           : kind == WEIR_RESULT_SCORES || kind == WEIR_RESULT_TEXT ? 1
                                                                                    : 0;
    if (of_rows == 0 || !group) continue;
    const uint32_t rows = extent(specs[group->rows].shape, 1);
    if (extent(specs[i].shape, of_rows) != rows)
      return bad_tensor(i, specs[i],
                        "an entry for each of " + std::to_string(rows) + " rows of tensor " +
                            std::to_string(group->rows));
  }
  return ok();
}

Status ResultReader::check(std::span<const TensorSpec> specs) const {
  if (!has_columns_) {
    if (specs.size() == 1) return draw::check_detections(specs[0]);
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "a stream of several tensors does not define which of them are results",
                 .offered = std::to_string(specs.size()) + " tensors without weir-columns",
                 .needed = "the caps field weir-columns, or one tensor of boxes",
                 .fix = "tensor_decoder mode=detection"};
  }
  if (specs.size() < columns_.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "a frame has fewer tensors than weir-columns names",
                 .offered = std::to_string(specs.size()) + " tensors",
                 .needed = std::to_string(columns_.size()) + " tensors"};
  for (size_t i = 0; i < columns_.size(); ++i)
    if (Status status = check(i, specs[i]); !status) return status;
  return check_groups(specs);
}

RowGroup ResultReader::plain_group(const TensorSpec& spec) const {
  RowGroup out = groups_[0];
  out.columns = plain_columns(spec.shape[0]);
  return out;
}

void ResultReader::read_maps(std::span<const TensorSpec> specs,
                             std::span<const ResultTensor> tensors, ResultFrame* out) const {
  for (uint32_t i = 0; i < columns_.size(); ++i) {
    const uint32_t width = extent(specs[i].shape, 0), height = extent(specs[i].shape, 1);
    if (columns_[i].kind == WEIR_RESULT_CLASS_MAP)
      out->class_maps.push_back({.source = source_of_[i],
                                 .tensor = i,
                                 .width = width,
                                 .height = height,
                                 .is_wide = specs[i].type == ElementType::UInt16,
                                 .values = tensors[i].bytes});
    if (columns_[i].kind == WEIR_RESULT_DEPTH)
      out->depths.push_back({.source = source_of_[i],
                             .tensor = i,
                             .width = width,
                             .height = height,
                             .values = tensors[i].bytes});
  }
}

void ResultReader::read_zones(uint32_t tensor, const ResultTensor& rows, ResultFrame* out) const {
  std::vector<float> n(columns_[tensor].length);
  for (uint32_t i = 0; i < extent(rows.spec.shape, 1); ++i) {
    std::memcpy(n.data(), rows.bytes.data() + i * n.size() * sizeof(float),
                n.size() * sizeof(float));
    const auto zone = to_zone(n[1]);
    if (!zone) continue;
    const ResultRow row(columns_[tensor], n.data());
    const int32_t class_index = std::max(row.class_index(), -1);
    if (zone_tables_[tensor] == ZoneTable::Counts)
      out->zone_counts.push_back({*zone, class_index, n[3], n[4], n[5], n[6], n[7], n[8], n[9]});
    else if (n[2] >= 1 && n[2] <= 5)
      out->zone_events.push_back(
          {*zone, static_cast<uint32_t>(n[2]) - 1, class_index, row.track(), n[5], n[6], n[7]});
  }
}

Status ResultReader::read(std::span<const ResultTensor> tensors, ResultFrame* out) const {
  out->clear();
  std::vector<TensorSpec> specs;
  for (const ResultTensor& tensor : tensors) specs.push_back(tensor.spec);
  if (Status status = check(specs); !status) return status;
  for (size_t i = 0; i < columns_.size(); ++i) {
    const auto needed = specs[i].bytes();
    if (needed && tensors[i].bytes.size() >= *needed) continue;
    return Error{
        .code = Code::FRAME_SIZE,
        .what = "a tensor of results is shorter than its shape requires",
        .offered = std::to_string(tensors[i].bytes.size()) + " bytes",
        .needed = std::to_string(needed.value_or(0)) + " bytes for " + specs[i].to_string(),
        .difference = "tensor " + std::to_string(i)};
  }
  RowReader rows(tensors, out);
  if (!has_columns_) rows.read(plain_group(specs[0]), 0);
  for (uint32_t i = 0, group = 0; has_columns_ && i < columns_.size(); ++i) {
    if (columns_[i].kind != WEIR_RESULT_ROWS) continue;
    if (zone_tables_[i] == ZoneTable::None) {
      rows.read(groups_[group], group);
      ++group;
      continue;
    }
    read_zones(i, tensors[i], out);
    rows.skip(extent(specs[i].shape, 1));
  }
  rows.end();
  read_maps(specs, tensors, out);
  return ok();
}

}  // namespace weir::records
