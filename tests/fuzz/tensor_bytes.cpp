// Fuzz target: every parser of bytes and texts of the tensor types. The first byte chooses.
#include <cstdint>
#include <string_view>

#include "core/filter/combination.hpp"
#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/sparse.hpp"

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
    case 4: {
      // What a header claims is allocated, so keep the claims small here.
      const auto header = weir::read_tensor_header(bytes);
      if (header && header->spec.bytes() < 1u << 20) (void)weir::to_dense(bytes, nullptr);
      break;
    }
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
