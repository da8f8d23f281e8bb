// Runs a plan row by row.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/plan.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "core/preprocess/plan_tables.hpp"
#include "core/preprocess/sum_kernels.hpp"
#include "core/preprocess/tap_kernels.hpp"
#include "core/simd/streamed_copy.hpp"

namespace weir::preprocess {
namespace {

// Whether all rows to be read are within the plane's memory.
bool holds(const Plane& plane, const Grid& grid) {
  constexpr int64_t kMost = int64_t{1} << 40;
  const int64_t size = static_cast<int64_t>(plane.memory.size());
  if (plane.offset > static_cast<size_t>(kMost) || plane.stride > kMost || plane.stride < -kMost)
    return false;
  const auto begin = [&](uint32_t row) {
    return static_cast<int64_t>(plane.offset + grid.first_byte) + int64_t{row} * plane.stride;
  };
  const auto [low, high] = std::minmax({begin(grid.rows.low()), begin(grid.rows.high() - 1)});
  return low >= 0 && high + static_cast<int64_t>(grid.bytes) <= size;
}

// The source row after the last one that target row `target` uses.
size_t end_of(const Grid& grid, size_t target) {
  return grid.rows.first(target) + grid.rows.weights(target).size();
}

}  // namespace

// One frame's run through the tables of a plan.
class PlanRun {
 public:
  PlanRun(const PlanTables& tables, const Planes& planes, std::span<std::byte> out,
          Workspace* workspace, const RowOptions& options, const FrameSums& sums)
      : t_(tables),
        p_(tables.preparation),
        planes_(planes),
        out_(out),
        w_(*workspace),
        sums_(sums),
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
    for (const Band& band : t_.bands) {
      const Plane& plane = planes_[band.plane];
      const Grid& grid = t_.grids[band.grid];
      if (!holds(plane, grid))
        return Error{.code = Code::FRAME_SIZE,
                     .what = "a picture is shorter than its size requires",
                     .offered = "plane " + std::to_string(band.plane) + " of " +
                                std::to_string(plane.memory.size()) + " bytes, offset " +
                                std::to_string(plane.offset) + ", stride " +
                                std::to_string(plane.stride),
                     .needed = "rows up to " + std::to_string(grid.rows.high()) +
                               ", each up to byte " + std::to_string(grid.first_byte + grid.bytes),
                     .fix = "check the upstream element"};
    }
    return ok();
  }

  void row(uint32_t y) noexcept {
    const Rect& content = t_.placement.content;
    const bool padded_only = y < content.y || y >= content.y + content.height;
    if (padded_only) return pad(y, 0, p_.width);
    pad(y, 0, content.x);
    pad(y, content.x + content.width, p_.width);
    resize(y - content.y);
    write(y);
  }

 private:
  size_t element_bytes() const noexcept { return size_of(p_.type); }
  size_t count() const noexcept { return t_.placement.content.width; }

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
    for (size_t b = 0; b < t_.bands.size(); ++b) {
      const Grid& grid = t_.grids[t_.bands[b].grid];
      const Plane& plane = planes_[t_.bands[b].plane];
      if (grid.sums.block > 1) {
        resize_sums(grid, b, target);
        continue;
      }
      const auto* memory = reinterpret_cast<const uint8_t*>(plane.memory.data());
      const auto row_at = [&](size_t row) {
        return memory + static_cast<ptrdiff_t>(plane.offset + grid.first_byte) +
               static_cast<ptrdiff_t>(row) * plane.stride;
      };
      const size_t count = grid.rows.weights(target).size();
      const size_t next = grid.rows.first(std::min(target + 1, t_.placement.content.height - 1));
      for (size_t k = 0; k < count; ++k) {
        w_.rows[k] = row_at(grid.rows.first(target) + k);
        w_.next_rows[k] = row_at(std::min<size_t>(next + k, grid.rows.high() - 1));
      }
      resize_taps(grid, b, target);
    }
  }

  SourceRows source_rows(size_t count) const noexcept {
    return {w_.rows.data(), w_.next_rows.data(), count};
  }

  // The destination of each lane of the band; unused lanes go to a scratch row.
  std::array<float*, 4> lanes_of(size_t band) const noexcept {
    std::array<float*, 4> out;
    out.fill(w_.lanes[3].data());
    for (size_t l = 0; l < t_.lanes.size(); ++l)
      if (t_.lanes[l].band == band) out[t_.lanes[l].offset] = w_.lanes[l].data();
    return out;
  }

  void resize_sums(const Grid& grid, size_t band, uint32_t target) noexcept {
    const auto sums = std::find_if(sums_.all.begin(), sums_.all.end(), [&](const BlockSums& one) {
      return one.samples() == grid.summed(t_.bands[band].plane);
    });
    const auto weights = grid.rows.weights(target);
    const size_t block = grid.sums.block;
    const SummedRows rows = sums->of_rows(grid.rows.first(target), weights.size(), block);
    // A power of two, so the products are exact.
    const float share = 1.0f / static_cast<float>(block * counted(grid.cosited));
    const auto weight = [&](size_t row) {
      return weights[std::min(row, weights.size() - 1)] * share;
    };
    const SumBlend blend{rows, weight(0), weight(1), weight(weights.size() - 1),
                         most_rows(block, grid.cosited) / sums->most_rows_of(block)};
    if (grid.sums.whole) return blend_whole(grid, blend, lanes_of(band));
    float* const blended = w_.blended.data();
    blend_sums(blend, 1, grid.bytes / block, &blended);
    gather(grid, band);
    // A single weight is not applied when pixels are gathered.
    if (grid.taps == 1) scale_last(grid, lanes_of(band));
  }

  void scale_last(const Grid& grid, const std::array<float*, 4>& lanes) const noexcept {
    if (grid.sums.last_scale == 1) return;
    for (size_t l = 0; l < grid.sampling.step; ++l) lanes[l][count() - 1] *= grid.sums.last_scale;
  }

  void blend_whole(const Grid& grid, const SumBlend& blend,
                   const std::array<float*, 4>& lanes) noexcept {
    blend_sums(blend, grid.sampling.step, count(), lanes.data());
    scale_last(grid, lanes);
  }

  void resize_taps(const Grid& grid, size_t band, uint32_t target) noexcept {
    const auto weights = grid.rows.weights(target);
    blend_rows(source_rows(weights.size()), weights.data(), grid.bytes, w_.blended.data());
    gather(grid, band);
  }

  void gather(const Grid& grid, size_t band) noexcept {
    if (grid.sampling.step > 2)
      return gather_pixels(w_.blended.data(), grid.index.data(), grid.weights.data(), grid.taps,
                           count(), lanes_of(band).data());
    for (size_t l = 0; l < t_.lanes.size(); ++l)
      if (t_.lanes[l].band == band)
        gather_row(w_.blended.data() + t_.lanes[l].offset, grid.index.data(), grid.weights.data(),
                   grid.taps, count(), w_.lanes[l].data());
  }

  // Writes floats directly to the tensor; streamed floats and all other types go through w_.lanes.
  void write(uint32_t y) noexcept {
    const uint32_t x = t_.placement.content.x;
    const bool together = p_.layout == Layout::Nhwc && p_.channels() == 3;
    const bool streamed = options_.streamed && !together && floats_;
    const bool direct = floats_ && !streamed;
    FloatTarget to{{}, direct && together, !direct};
    for (size_t c = 0; c < p_.channels(); ++c)
      to.rows[c] = direct ? reinterpret_cast<float*>(place(c, x, y)) : w_.lanes[c].data();
    constexpr NumberRule kAsTheyAre[3];
    const float* in[3] = {};
    for (size_t s = 0; s < t_.colors.samples; ++s) in[s] = w_.lanes[t_.lane_of_sample[s]].data();
    finish_row(in, t_.colors, floats_ ? t_.numbers.data() : kAsTheyAre, to, count());
    if (direct) return;
    const void* rows[3] = {};
    for (size_t c = 0; c < p_.channels(); ++c) {
      if (streamed) {
        copy_streamed(place(c, x, y), reinterpret_cast<const std::byte*>(w_.lanes[c].data()),
                      count() * sizeof(float));
        continue;
      }
      std::byte* const numbers = together ? w_.numbers[c].data() : place(c, x, y);
      write_numbers(t_.numbers[c], p_.type, w_.lanes[c].data(), count(), numbers);
      rows[c] = numbers;
    }
    if (together) interleave_three(rows, element_bytes(), count(), place(0, x, y));
  }
  const PlanTables& t_;
  const Preparation& p_;
  const Planes& planes_;
  std::span<std::byte> out_;
  Workspace& w_;
  const FrameSums& sums_;
  const RowOptions& options_;
  const bool floats_;  // the tensor is float32 and aligned for it
};

Result<Plan> Plan::make(Preparation preparation) {
  if (auto status = check(preparation); !status) return status.error();
  const Rect all{0, 0, preparation.source.width, preparation.source.height};
  if (const auto& region = preparation.region)
    if (auto status = check_region(preparation, preparation.crop.value_or(all), *region); !status)
      return status.error();
  return Plan(std::make_shared<PlanTables>(std::move(preparation)));
}

const Preparation& Plan::preparation() const noexcept {
  return tables_->preparation;
}
const Placement& Plan::placement() const noexcept {
  return tables_->placement;
}

Status Plan::set_crop(const Rect& crop) {
  if (auto status = check_crop(preparation().source, crop); !status) return status;
  if (tables_.use_count() > 1) tables_ = std::make_shared<PlanTables>(*tables_);
  tables_->set_crop(crop);
  return ok();
}

Status Plan::set_region(const Rect& picture, const Box& region) {
  if (auto status = check_crop(preparation().source, picture); !status) return status;
  if (auto status = check_region(preparation(), picture, region); !status) return status;
  if (tables_.use_count() > 1) tables_ = std::make_shared<PlanTables>(*tables_);
  tables_->set_region(picture, region);
  return ok();
}

Workspace Plan::workspace() const {
  Workspace w;
  grow(&w);
  return w;
}

void Plan::grow(Workspace* w) const {
  const auto at_least = [](auto* memory, size_t size) {
    if (memory->size() < size) memory->resize(size);
  };
  const size_t count = padded(tables_->placement.content.width);
  for (const Grid& grid : tables_->grids) {
    at_least(&w->rows, grid.rows.most_weights());
    at_least(&w->next_rows, grid.rows.most_weights());
    at_least(&w->blended, padded(grid.bytes) + kRowBlock);
  }
  at_least(&w->lanes, 4);
  for (auto& lane : w->lanes) at_least(&lane, count);
  at_least(&w->numbers, 3);
  for (auto& numbers : w->numbers) at_least(&numbers, count * sizeof(float));
}

// Calls f(sums, grid, first target, last target) for each band that uses block sums.
template <class F>
void Plan::for_sums(uint32_t first, uint32_t count, FrameSums* sums, F&& f) const {
  const Rect& content = tables_->placement.content;
  const uint32_t bottom = content.y + content.height;
  const uint32_t begin = std::clamp(first, content.y, bottom);
  const uint32_t end = std::clamp(first + std::min(count, preparation().height), begin, bottom);
  if (begin == end) return;
  for (const Band& band : tables_->bands) {
    const Grid& grid = tables_->grids[band.grid];
    if (grid.sums.block == 1) continue;
    const SummedSamples of = grid.summed(band.plane);
    auto found = std::find_if(sums->all.begin(), sums->all.end(),
                              [&](const BlockSums& one) { return one.samples() == of; });
    if (found == sums->all.end()) {
      found = std::find_if(sums->all.begin(), sums->all.end(),
                           [](const BlockSums& one) { return !one.wanted(); });
      if (found == sums->all.end())
        found = sums->all.emplace(found, of);
      else
        found->aim_at(of);
    }
    const size_t last = end - 1 - content.y;
    f(*found, grid, begin - content.y, last);
  }
}

void Plan::want_sums(uint32_t first, uint32_t count, FrameSums* sums) const {
  for_sums(first, count, sums, [](BlockSums& of, const Grid& grid, size_t top, size_t bottom) {
    of.want(grid.rows.first(top), end_of(grid, bottom), grid.sums.block, grid.sums.rows);
    if (grid.sums.rows >= kRowsTogether) return;
    for (size_t t = top; t <= bottom; ++t) {
      const size_t first = grid.rows.first(t), end = end_of(grid, t);
      of.want_begin(first);
      of.want_begin(end);
      if (grid.sums.rows > 1) continue;
      of.want_begin(first + 1);  // the first and the last row may have different weights
      of.want_begin(end - 1);
    }
  });
}

Status Plan::run_rows(const Planes& planes, std::span<std::byte> out, uint32_t first,
                      uint32_t count, Workspace* workspace, const RowOptions& options) const {
  const bool alone = options.sums == nullptr;
  FrameSums* const sums = alone ? &workspace->sums : options.sums;
  PlanRun run(*tables_, planes, out, workspace, options, *sums);
  if (!options.checked)
    if (auto status = run.check(); !status) return status;
  if (count == 0) return ok();
  if (alone) {
    sums->clear();
    want_sums(first, count, sums);
    sums->reserve();
  }
  for_sums(first, count, sums, [&](BlockSums& of, const Grid& grid, size_t, size_t bottom) {
    const Plane& plane = planes[of.samples().plane];
    of.make(reinterpret_cast<const uint8_t*>(plane.memory.data()) + plane.offset, plane.stride,
            end_of(grid, bottom));
  });
  const uint32_t height = preparation().height;
  for (uint32_t y = first; y < height && y - first < count; ++y) run.row(y);
  return ok();
}

}  // namespace weir::preprocess
