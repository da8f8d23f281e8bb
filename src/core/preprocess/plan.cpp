// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/plan.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "core/preprocess/plan_tables.hpp"
#include "core/preprocess/tap_kernels.hpp"
#include "core/simd/streamed_copy.hpp"

namespace weir::preprocess {
namespace {

// What is read of a plane.
struct PlanePart {
  uint32_t first_row = 0, end_row = 0;
  size_t first_byte = 0, bytes = 0;  // of each row
};

// Whether all rows to be read are within the plane's memory.
bool holds(const Plane& plane, const PlanePart& part) {
  constexpr int64_t kMax = int64_t{1} << 40;
  const int64_t size = static_cast<int64_t>(plane.memory.size());
  if (plane.offset > static_cast<size_t>(kMax) || plane.stride > kMax || plane.stride < -kMax)
    return false;
  const auto begin = [&](uint32_t row) {
    return static_cast<int64_t>(plane.offset + part.first_byte) + int64_t{row} * plane.stride;
  };
  const auto [low, high] = std::minmax({begin(part.first_row), begin(part.end_row - 1)});
  return low >= 0 && high + static_cast<int64_t>(part.bytes) <= size;
}

}  // namespace

// One frame's run through the tables of a plan.
class PlanRun {
 public:
  PlanRun(const PlanTables& tables, const Planes& planes, std::span<std::byte> out,
          Workspace* workspace, const RowOptions& options)
      : t_(tables),
        p_(tables.preparation),
        planes_(planes),
        out_(out),
        w_(*workspace),
        options_(options),
        floats_(p_.type == ElementType::Float32 &&
                reinterpret_cast<uintptr_t>(out.data()) % sizeof(float) == 0) {}

  Status check() const {
    const uint64_t needed = *p_.tensor().bytes();
    if (out_.size() != needed)
      return Error{.code = Code::FRAME_SIZE,
                   .what = "the memory for the tensor has the wrong size",
                   .offered = std::to_string(out_.size()) + " bytes",
                   .needed = std::to_string(needed) + " bytes"};
    for (const PlaneGrid& plane_grid : t_.plane_grids) {
      const Plane& plane = planes_[plane_grid.plane];
      const Grid& grid = t_.grids[plane_grid.grid];
      const PlanePart part = part_of(grid);
      if (!holds(plane, part))
        return Error{.code = Code::FRAME_SIZE,
                     .what = "a picture is shorter than its size requires",
                     .offered = "plane " + std::to_string(plane_grid.plane) + " of " +
                                std::to_string(plane.memory.size()) + " bytes, offset " +
                                std::to_string(plane.offset) + ", stride " +
                                std::to_string(plane.stride),
                     .needed = "rows up to " + std::to_string(part.end_row) + ", each up to byte " +
                               std::to_string(part.first_byte + part.bytes),
                     .fix = "check the upstream element"};
    }
    return ok();
  }

  void row(uint32_t y) noexcept {
    const Rect& content = t_.placement.content;
    const bool padded_only = y < content.y || y >= content.y + content.height;
    if (padded_only) return pad(y, 0, p_.width);
    std::pair<uint32_t, uint32_t> columns{content.x, content.x + content.width};
    if (t_.placement.rotated) columns = t_.placement.rotated->columns_inside(y);
    pad(y, 0, columns.first);
    pad(y, columns.second, p_.width);
    if (columns.first == columns.second) return;
    if (t_.placement.rotated)
      rotate(y, columns);
    else
      resize(y - content.y);
    write(y, columns.first, columns.second - columns.first);
  }

 private:
  PlanePart part_of(const Grid& grid) const noexcept {
    if (!t_.placement.rotated)
      return {grid.rows.low(), grid.rows.high(), grid.first_byte, grid.bytes};
    const Rect& picture = t_.placement.rotated->picture();
    const Component& c = grid.sampling;
    const auto rows = samples_of(picture.y, picture.height, c.halved_rows);
    const auto columns = samples_of(picture.x, picture.width, c.halved_columns);
    return {rows.first, rows.second, size_t{columns.first} * c.step,
            size_t{columns.second - columns.first} * c.step};
  }

  size_t element_bytes() const noexcept { return element_size(p_.type); }
  size_t pixels() const noexcept { return t_.placement.content.width; }

  // The address of element (channel, x, y); in NHWC, of the pixel's first element.
  std::byte* place(size_t channel, uint32_t x, uint32_t y) const noexcept {
    const size_t pixel = size_t{y} * p_.width + x;
    const size_t element = p_.layout == Layout::Nhwc
                               ? pixel * p_.channels()
                               : channel * size_t{p_.width} * p_.height + pixel;
    return out_.data() + element * element_bytes();
  }

  void pad(uint32_t y, uint32_t from, uint32_t to) const noexcept {
    if (from >= to) return;
    const bool together = p_.layout == Layout::Nhwc;
    const size_t rows = together ? 1 : p_.channels();
    const size_t pixel_bytes = element_bytes() * (together ? p_.channels() : 1);
    for (size_t c = 0; c < rows; ++c)
      std::memcpy(place(c, from, y), t_.padding.data() + c * p_.width * pixel_bytes,
                  (to - from) * pixel_bytes);
  }

  void resize(uint32_t target) noexcept {
    for (size_t b = 0; b < t_.plane_grids.size(); ++b) {
      const Grid& grid = t_.grids[t_.plane_grids[b].grid];
      const Plane& plane = planes_[t_.plane_grids[b].plane];
      const auto* memory = reinterpret_cast<const uint8_t*>(plane.memory.data());
      const auto row_at = [&](size_t row) {
        return memory + static_cast<ptrdiff_t>(plane.offset + grid.first_byte) +
               static_cast<ptrdiff_t>(row) * plane.stride;
      };
      const auto weights = grid.rows.weights(target);
      const size_t count = weights.size();
      const size_t next = grid.rows.first(std::min(target + 1, t_.placement.content.height - 1));
      for (size_t k = 0; k < count; ++k) {
        w_.rows[k] = row_at(grid.rows.first(target) + k);
        w_.next_rows[k] = row_at(std::min<size_t>(next + k, grid.rows.high() - 1));
      }
      blend_rows({w_.rows.data(), w_.next_rows.data(), count}, weights.data(), grid.bytes,
                 w_.blended.data());
      for (size_t l = 0; l < t_.components.size(); ++l)
        if (t_.components[l].plane_grid == b)
          gather_row(w_.blended.data() + t_.components[l].offset, grid.index.data(),
                     grid.weights.data(), grid.taps, pixels(), w_.components[l].data());
    }
  }

  void rotate(uint32_t y, std::pair<uint32_t, uint32_t> columns) noexcept {
    for (size_t l = 0; l < t_.components.size(); ++l) {
      const PlaneGrid& at = t_.plane_grids[t_.components[l].plane_grid];
      const Plane& plane = planes_[at.plane];
      const ComponentRows in{reinterpret_cast<const uint8_t*>(plane.memory.data()) + plane.offset +
                                 t_.components[l].offset,
                             plane.stride, t_.grids[at.grid].sampling, p_.source.cosited_columns,
                             p_.source.cosited_rows};
      sample_row(*t_.placement.rotated, in, p_.resize, y, columns, w_.components[l].data());
    }
  }

  // The row of each sample that the colours are made of.
  std::array<const float*, 3> sources() const noexcept {
    std::array<const float*, 3> rows{};
    for (size_t s = 0; s < t_.colors.samples; ++s)
      rows[s] = w_.components[t_.component_of_sample[s]].data();
    return rows;
  }

  // Writes floats directly to the tensor; streamed floats and all other types go through
  // w_.components.
  void write(uint32_t y, uint32_t x, size_t pixels) noexcept {
    const bool together = p_.layout == Layout::Nhwc && p_.channels() == 3;
    const bool streamed = options_.streamed && !together && floats_;
    const bool direct = floats_ && !streamed;
    FloatTarget to{{}, direct && together, !direct};
    for (size_t c = 0; c < p_.channels(); ++c)
      to.rows[c] = direct ? reinterpret_cast<float*>(place(c, x, y)) : w_.components[c].data();
    constexpr NumberRule kAsTheyAre[3];
    finish_row(sources().data(), t_.colors, floats_ ? t_.numbers.data() : kAsTheyAre, to, pixels);
    if (direct) return;
    const void* rows[3] = {};
    for (size_t c = 0; c < p_.channels(); ++c) {
      if (streamed) {
        copy_streamed(place(c, x, y), reinterpret_cast<const std::byte*>(w_.components[c].data()),
                      pixels * sizeof(float));
        continue;
      }
      std::byte* const numbers = together ? w_.numbers[c].data() : place(c, x, y);
      write_numbers(t_.numbers[c], p_.type, w_.components[c].data(), pixels, numbers);
      rows[c] = numbers;
    }
    if (together) interleave_three(rows, element_bytes(), pixels, place(0, x, y));
  }
  const PlanTables& t_;
  const Preparation& p_;
  const Planes& planes_;
  std::span<std::byte> out_;
  Workspace& w_;
  const RowOptions& options_;
  const bool floats_;  // the tensor is float32 and aligned for it
};

Result<PreprocessPlan> PreprocessPlan::make(Preparation preparation) {
  if (auto status = check(preparation); !status) return status.error();
  const Rect all{0, 0, preparation.source.width, preparation.source.height};
  if (const auto& region = preparation.region)
    if (auto status = check_region(preparation, preparation.crop.value_or(all), *region); !status)
      return status.error();
  return PreprocessPlan(std::make_shared<PlanTables>(std::move(preparation)));
}

const Preparation& PreprocessPlan::preparation() const noexcept {
  return tables_->preparation;
}
const Placement& PreprocessPlan::placement() const noexcept {
  return tables_->placement;
}

Status PreprocessPlan::set_crop(const Rect& crop) {
  if (auto status = check_crop(preparation().source, crop); !status) return status;
  if (tables_.use_count() > 1) tables_ = std::make_shared<PlanTables>(*tables_);
  tables_->set_crop(crop);
  return ok();
}

Status PreprocessPlan::set_region(const Rect& picture, const Roi& region) {
  if (auto status = check_crop(preparation().source, picture); !status) return status;
  if (auto status = check_region(preparation(), picture, region); !status) return status;
  if (tables_.use_count() > 1) tables_ = std::make_shared<PlanTables>(*tables_);
  tables_->set_region(picture, region);
  return ok();
}

Workspace PreprocessPlan::workspace() const {
  Workspace w;
  grow(&w);
  return w;
}

void PreprocessPlan::grow(Workspace* w) const {
  const auto at_least = [](auto* memory, size_t size) {
    if (memory->size() < size) memory->resize(size);
  };
  const size_t count = padded(tables_->placement.content.width);
  for (const Grid& grid : tables_->grids) {
    at_least(&w->rows, grid.rows.max_weights());
    at_least(&w->next_rows, grid.rows.max_weights());
    at_least(&w->blended, grid.bytes);
  }
  at_least(&w->components, 3);
  for (auto& component : w->components) at_least(&component, count);
  at_least(&w->numbers, 3);
  for (auto& numbers : w->numbers) at_least(&numbers, count * sizeof(float));
}

Status PreprocessPlan::run_rows(const Planes& planes, std::span<std::byte> out, uint32_t first,
                                uint32_t count, Workspace* workspace,
                                const RowOptions& options) const {
  PlanRun run(*tables_, planes, out, workspace, options);
  if (!options.checked)
    if (auto status = run.check(); !status) return status;
  const uint32_t height = preparation().height;
  for (uint32_t y = first; y < height && y - first < count; ++y) run.row(y);
  return ok();
}

}  // namespace weir::preprocess
