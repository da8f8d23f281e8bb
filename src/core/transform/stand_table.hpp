// Standardises elements of 8 bits by a table of the 256 results.
#pragma once
#include <span>

#include "core/transform/stand_scale.hpp"

namespace weir::transform {

// Whether there are enough elements that the table is worth its making.
bool has_stand_table(const StandTensor& tensor, const StandTypes& types) noexcept;

// The results are those of run_stand_strip() with the same scale.
void run_stand_table(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept;

// What a table of bytes adds as its index grows: `change` from `first` on.
struct TableStep {
  uint8_t first, change;
};
// out[i] = start + the changes of all steps up to in[i], modulo 256. (stand_steps.cpp)
void run_table_steps(std::span<const TableStep> steps, uint8_t start, size_t count, bool accelerate,
                     const std::byte* in, std::byte* out) noexcept;

}  // namespace weir::transform
