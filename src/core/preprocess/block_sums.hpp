// BlockSums: the samples of each row of a plane added up in blocks, for all layers of a pyramid
// that are made of whole blocks.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace weir::preprocess {

// Blocks are of 4, 8, 16, 32 or 64 samples: sums of bytes fit into 16 bits.
inline constexpr size_t kLeastBlock = 4, kMostBlock = 64;

// The samples from low to below high of some rows of a plane, whose samples are `step` lanes of a
// byte.
class BlockSums {
 public:
  BlockSums(size_t plane, size_t low, size_t high, size_t step) noexcept
      : plane_(plane), low_(low), high_(high), step_(step) {}
  bool is_of(size_t plane, size_t low, size_t high) const noexcept {
    return plane == plane_ && low == low_ && high == high_;
  }
  size_t plane() const noexcept { return plane_; }

  void want(size_t first_row, size_t end_row, size_t block) noexcept;
  // Nothing is wanted any more; memory is kept.
  void clear() noexcept { first_row_ = SIZE_MAX, end_row_ = 0, most_ = 0; }
  // Allocates what make() writes.
  void reserve();
  // The rows in front of `end_row` that were not made yet: row r of the plane begins at memory +
  // r * stride. Precondition: wanted, and reserved since.
  void make(const uint8_t* memory, ptrdiff_t stride, size_t end_row) noexcept;

  // Lane l of the b-th block at b * step + l; the first block is the first one that lies within the
  // samples, blocks being counted from the plane's first sample. Precondition: wanted, and made.
  // Behind the last one are kRowBlock elements more, of any value.
  const uint16_t* row(size_t row, size_t block) const noexcept;
  // From one row to the next.
  size_t stride(size_t block) const noexcept { return width(block); }

 private:
  size_t begin(size_t block) const noexcept { return (low_ + block - 1) / block; }
  size_t end(size_t block) const noexcept { return high_ / block; }
  size_t width(size_t block) const noexcept { return (end(block) - begin(block)) * step_; }

  // Lanes of the blocks before that are no part of the first one.
  size_t skipped(size_t block) const noexcept {
    return (2 * begin(block) - begin(block / 2)) * step_;
  }

  size_t plane_, low_, high_, step_;
  size_t first_row_ = SIZE_MAX, end_row_ = 0, made_ = 0, most_ = 0;
  std::array<std::vector<uint16_t>, 5> levels_;  // of 4 to 64
  std::vector<uint16_t> pairs_;
};

// out[b * step + l] = in[2 * b * step + l] + in[(2 * b + 1) * step + l]
void add_byte_pairs(const uint8_t* in, size_t step, size_t blocks, uint16_t* out) noexcept;
void add_pairs(const uint16_t* in, size_t step, size_t blocks, uint16_t* out) noexcept;

// out[i] = sum over k of weights[k] * rows[k][i]. Rows and `out` go on to a multiple of kRowBlock.
void blend_sums(const uint16_t* const* rows, const float* weights, size_t taps, size_t count,
                float* out) noexcept;

}  // namespace weir::preprocess
