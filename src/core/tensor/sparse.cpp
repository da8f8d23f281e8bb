// Dense <-> sparse (docs/compatibility/types-and-caps.md 1.8).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/sparse.hpp"

#include <cstring>
#include <string>
#include <type_traits>

#include "core/tensor/nonzero.hpp"

namespace weir {
namespace {

Error invalid_sparse(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::HEADER_INVALID,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "check the element or program that wrote the stream"};
}

// Minus zero counts as zero, so its sign is lost.
NonzeroElements nonzero_elements(ElementType type) {
  return visit_type(type, []<class T>(std::type_identity<T>) {
    return NonzeroElements{sizeof(T), std::is_floating_point_v<T> || std::is_same_v<T, float16>};
  });
}

}  // namespace

Result<TensorHeader> sparse_header(const TensorSpec& spec, std::span<const std::byte> dense) {
  const auto bytes = spec.bytes();
  if (!bytes || *bytes != dense.size())
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a tensor's size does not match its type and dimension",
                 .offered = std::to_string(dense.size()) + " bytes",
                 .needed = spec.to_string()};
  if (*spec.shape.count() > UINT32_MAX)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a tensor is too large for the sparse format",
                 .offered = std::to_string(*spec.shape.count()) + " elements",
                 .needed = "at most 4294967295"};
  TensorHeader header;
  header.spec = spec;
  header.format = Format::Sparse;
  const size_t nonzero =
      nonzero_elements(spec.type).count(dense.data(), static_cast<size_t>(*spec.shape.count()));
  header.nonzero_count = static_cast<uint32_t>(nonzero);
  return header;
}

void write_sparse(const TensorHeader& header, std::span<const std::byte> dense,
                  std::span<std::byte> out) noexcept {
  write_tensor_header(header, out.first<kTensorHeaderBytes>());
  std::byte* values = out.data() + kTensorHeaderBytes;
  std::byte* indices = values + size_t{header.nonzero_count} * element_size(header.spec.type);
  nonzero_elements(header.spec.type)
      .write(dense.data(), static_cast<size_t>(*header.spec.shape.count()), header.nonzero_count,
             values, indices);
}

Result<TensorHeader> read_sparse_header(std::span<const std::byte> chunk) {
  auto header = read_tensor_chunk(chunk);
  if (!header) return header;
  if (header->format != Format::Sparse)
    return invalid_sparse("a tensor is not sparse", std::string(to_string(header->format)),
                          "sparse");
  // A small header must not allocate huge memory.
  constexpr uint64_t kDenseLimit = uint64_t{1} << 32;
  if (*header->spec.bytes() > kDenseLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a sparse tensor is too large to be made dense",
                 .offered = header->spec.to_string(),
                 .needed = "at most 4 GiB"};
  return header;
}

Status read_sparse(const TensorHeader& header, std::span<const std::byte> chunk,
                   std::span<std::byte> dense) {
  const size_t size = element_size(header.spec.type), nonzero = header.nonzero_count;
  const uint64_t count = *header.spec.shape.count();
  const std::byte* values = chunk.data() + kTensorHeaderBytes;
  const std::byte* indices = values + nonzero * size;
  std::memset(dense.data(), 0, dense.size());
  return visit_type(header.spec.type, [&]<class T>(std::type_identity<T>) -> Status {
    uint64_t min = 0;
    for (size_t i = 0; i < nonzero; ++i) {
      uint32_t index;
      std::memcpy(&index, indices + 4 * i, 4);
      if (index >= count || index < min)
        return invalid_sparse("a sparse tensor has a bad index",
                              std::to_string(index) + " as index " + std::to_string(i),
                              "ascending indices below " + std::to_string(count));
      std::memcpy(dense.data() + index * sizeof(T), values + i * sizeof(T), sizeof(T));
      min = uint64_t{index} + 1;
    }
    return ok();
  });
}

Result<std::vector<std::byte>> to_sparse(const TensorSpec& spec, std::span<const std::byte> dense) {
  const auto header = sparse_header(spec, dense);
  if (!header) return header.error();
  std::vector<std::byte> out(kTensorHeaderBytes + static_cast<size_t>(*header->payload_bytes()));
  write_sparse(*header, dense, out);
  return out;
}

Result<std::vector<std::byte>> to_dense(std::span<const std::byte> chunk, TensorSpec* spec_out) {
  const auto header = read_sparse_header(chunk);
  if (!header) return header.error();
  std::vector<std::byte> dense(static_cast<size_t>(*header->spec.bytes()));
  if (auto status = read_sparse(*header, chunk, dense); !status) return status.error();
  if (spec_out) *spec_out = header->spec;
  return dense;
}

}  // namespace weir
