// Fuzz target: every parser of bytes and texts of tensor types. The first byte selects one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <string_view>

#include "core/filter/combination.hpp"
#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/sparse.hpp"
#include "fuzz_input.hpp"

namespace {

// Parses headers with any claimed size. The element limits what it allocates for one: here 64 MiB.
void densify(std::span<const std::byte> chunk) {
  constexpr uint64_t kMax = 1 << 26;
  const auto header = weir::read_sparse_header(chunk);
  if (!header || *header->spec.bytes() > kMax) return;
  weir::TensorSpec spec;
  const auto dense = weir::to_dense(chunk, &spec);
  if (!dense) return;
  const auto sparse = weir::to_sparse(spec, *dense);
  weir::fuzz::require(static_cast<bool>(sparse), "a dense tensor has a sparse form");
  const auto again = weir::to_dense(*sparse, nullptr);
  weir::fuzz::require(again && again->size() == dense->size(), "a dense tensor comes back");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::span bytes(reinterpret_cast<const std::byte*>(data) + 1, size - 1);
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 8) {
    case 0:
      (void)weir::read_tensor_chunk(bytes);
      break;
    case 1:
      (void)weir::walk_chunks(bytes);
      break;
    case 2:
      (void)weir::read_packed_tensors(bytes, weir::Format::Static);
      break;
    case 3:
      (void)weir::read_packed_tensors(bytes, weir::Format::Flexible);
      break;
    case 4:
      densify(bytes);
      break;
    case 5:
      (void)weir::parse_shape_list(text);
      break;
    case 6:
      (void)weir::parse_type_list(text);
      break;
    default:
      (void)weir::parse_output_combination(text);
      break;
  }
  return 0;
}
