// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/zoned_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/records/zone_columns.hpp"
#include "weir/results.hpp"

namespace weir::records {
namespace {

Error no_tracks(const ResultRoles& roles) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the results have no tracks, which tensor_zones needs for counting",
               .offered = roles.empty() ? "a stream without weir-columns"
                                        : "weir-columns=\"" + columns_text(roles) + "\"",
               .needed = "rows with the columns x1,y1,x2,y2 and track",
               .fix = "tensor_decoder mode=detection ! tensor_tracker ! tensor_zones"};
}

Error zones_twice(const ResultRoles& roles) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the results already have zones",
               .offered = "weir-columns=\"" + columns_text(roles) + "\"",
               .needed = "one tensor_zones for a stream",
               .fix = "tensor_zones zones=all.json, a file with the zones of both"};
}

TensorSpec rows_spec(size_t length, size_t rows) {
  Shape shape{static_cast<uint32_t>(length), static_cast<uint32_t>(rows)};
  shape.set_rank(2);
  return {.type = ElementType::Float32, .shape = shape, .name = {}};
}

OutputTensor make_table(size_t length, std::vector<float> numbers) {
  OutputTensor out{.spec = rows_spec(length, numbers.size() / length)};
  out.numbers = std::move(numbers);
  out.is_table = true;
  return out;
}

uint32_t get_length(const char* columns) {
  return result_columns(columns, 0).value_or(weir_result_columns{}).length;
}

}  // namespace

Result<ZonedResults> ZonedResults::make(const ResultRoles& roles, ZonedSettings settings) {
  ZonedResults out;
  auto reader = ResultReader::make(columns_text(roles), sources_text(roles));
  if (!reader) return reader.error();
  if (reader->has_zones()) return zones_twice(roles);
  out.reader_ = *std::move(reader);
  out.n_inputs_ = roles.size();
  out.roles_ = roles;
  for (ResultRole& role : out.roles_) {
    const auto columns = result_columns(role.columns, 0);
    out.columns_.push_back(columns.value_or(weir_result_columns{}));
    const bool is_row = columns && columns->kind == WEIR_RESULT_ROWS;
    out.is_widened_.push_back(is_row && columns->box >= 0 && columns->track >= 0);
    if (!out.is_widened_.back()) continue;
    for (const char* name : {"speed", "ground-speed", "zone", "dwell"})
      if (find_column(role.columns, name).first >= 0) return zones_twice(roles);
    role.columns = with_zone_columns(role.columns, settings.zones_per_object);
  }
  if (std::count(out.is_widened_.begin(), out.is_widened_.end(), true) == 0)
    return no_tracks(roles);
  out.roles_.push_back({kZoneCountColumns, settings.source});
  out.roles_.push_back({kZoneEventColumns, settings.source});
  out.settings_ = std::move(settings);
  auto whole = ResultReader::make(columns_text(out.roles_), sources_text(out.roles_));
  if (!whole) return whole.error();
  return out;
}

namespace {

bool is_finite_box(const Box& box) noexcept {
  return std::isfinite(box.width()) && std::isfinite(box.height()) && std::isfinite(box.x1) &&
         std::isfinite(box.y1);
}

zone::Sighting make_sighting(const ResultRow& row, uint32_t group, bool has_class) {
  return {.group = group,
          .track = row.track(),
          .class_index = has_class ? std::max(row.class_index(), zone::kNoClass) : zone::kNoClass,
          .box = row.box(),
          .rotation = std::isfinite(row.rotation()) ? row.rotation() : 0};
}

}  // namespace

Status ZonedResults::read(std::span<const ResultTensor> tensors, std::vector<zone::Sighting>* out) {
  out->clear();
  rows_.clear();
  if (tensors.empty()) return ok();  // no results
  if (Status status = reader_.read(tensors, &frame_); !status) return status;
  std::vector<float> numbers;
  for (uint32_t i = 0; i < n_inputs_; ++i) {
    if (!is_widened_[i]) continue;
    const size_t length = columns_[i].length;
    numbers.resize(length);
    const uint32_t count = tensors[i].spec.shape.rank() > 1 ? tensors[i].spec.shape[1] : 1;
    for (uint32_t row = 0; row < count; ++row) {
      std::memcpy(numbers.data(), tensors[i].bytes.data() + row * length * sizeof(float),
                  length * sizeof(float));
      const ResultRow found(columns_[i], numbers.data());
      if (found.is_background() || !is_finite_box(found.box())) continue;
      out->push_back(make_sighting(found, i, columns_[i].class_index >= 0));
      rows_.push_back({i, row});
    }
  }
  return ok();
}

OutputTensor ZonedResults::widened(const ResultTensor& tensor, uint32_t index,
                                   const zone::ZoneCounter& counter, size_t* next,
                                   uint64_t* unnamed) const {
  const size_t length = columns_[index].length, more = 2 + 2 * size_t{settings_.zones_per_object};
  const uint32_t count = tensor.spec.shape.rank() > 1 ? tensor.spec.shape[1] : 1;
  OutputTensor out{.spec = rows_spec(length + more, count)};
  out.numbers.resize((length + more) * count);
  for (uint32_t row = 0; row < count; ++row) {
    float* const to = out.numbers.data() + row * (length + more);
    std::memcpy(to, tensor.bytes.data() + row * length * sizeof(float), length * sizeof(float));
    if (*next == rows_.size() || rows_[*next].tensor != index || rows_[*next].row != row) continue;
    *unnamed += write_zone_columns(counter, *next, std::span(to + length, more));
    ++*next;
  }
  return out;
}

std::vector<OutputTensor> ZonedResults::write(std::span<const ResultTensor> tensors,
                                              const zone::ZoneCounter& counter,
                                              uint64_t* unnamed) const {
  std::vector<OutputTensor> out;
  size_t next = 0;
  const auto as_it_is = [&](size_t i) {
    out.push_back({.spec = tensors[i].spec, .input = static_cast<int32_t>(i)});
  };
  const size_t with_role = std::min(n_inputs_, tensors.size());
  for (uint32_t i = 0; i < with_role; ++i)
    if (is_widened_[i])
      out.push_back(widened(tensors[i], i, counter, &next, unnamed));
    else
      as_it_is(i);
  static const uint32_t kCountLength = get_length(kZoneCountColumns),
                        kEventLength = get_length(kZoneEventColumns);
  std::vector<float> counts, events;
  append_count_rows(counter, &counts);
  append_event_rows(counter, &events);
  out.push_back(make_table(kCountLength, std::move(counts)));
  out.push_back(make_table(kEventLength, std::move(events)));
  for (size_t i = with_role; i < tensors.size(); ++i) as_it_is(i);
  return out;
}

}  // namespace weir::records
