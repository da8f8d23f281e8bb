// Dense <-> sparse (specification 1.8).
#include "core/tensor/sparse.hpp"

#include <cstring>
#include <string>

namespace weir {
namespace {

Error invalid(std::string what, std::string offered, std::string needed) {
  return Error{Code::HEADER_INVALID,
               std::move(what),
               std::move(offered),
               std::move(needed),
               "",
               "check the element or program that wrote the stream"};
}

// Minus zero is a zero: its value is lost, as with every sparse form by value.
template <class T>
bool is_zero(const T& value) {
  if constexpr (std::is_same_v<T, float16>)
    return (value.bits & 0x7FFFu) == 0;
  else
    return value == T{};
}

template <class T>
std::vector<uint32_t> nonzero_indices(std::span<const std::byte> dense) {
  std::vector<uint32_t> out;
  for (size_t i = 0; i < dense.size() / sizeof(T); ++i) {
    T value;
    std::memcpy(&value, dense.data() + i * sizeof(T), sizeof(T));
    if (!is_zero(value)) out.push_back(static_cast<uint32_t>(i));
  }
  return out;
}

}  // namespace

Result<std::vector<std::byte>> to_sparse(const TensorSpec& spec, std::span<const std::byte> dense) {
  const auto bytes = spec.bytes();
  if (!bytes || *bytes != dense.size())
    return Error{Code::FRAME_SIZE,
                 "a tensor has another size than its type and dimension say",
                 std::to_string(dense.size()) + " bytes",
                 spec.to_string(),
                 "",
                 ""};
  if (*spec.shape.count() > UINT32_MAX)
    return Error{Code::LIMIT_EXCEEDED,
                 "a tensor is too big for the sparse format",
                 std::to_string(*spec.shape.count()) + " elements",
                 "at most 4294967295",
                 "",
                 ""};
  const auto indices = visit_type(
      spec.type, [&]<class T>(std::type_identity<T>) { return nonzero_indices<T>(dense); });
  const size_t size = size_of(spec.type);
  TensorHeader header;
  header.spec = spec;
  header.format = Format::Sparse;
  header.nonzero_count = static_cast<uint32_t>(indices.size());
  std::vector<std::byte> out(kTensorHeaderBytes + indices.size() * (size + 4));
  write_tensor_header(header, std::span(out).first<kTensorHeaderBytes>());
  std::byte* values = out.data() + kTensorHeaderBytes;
  for (const uint32_t index : indices) {
    std::memcpy(values, dense.data() + index * size, size);
    values += size;
  }
  if (!indices.empty()) std::memcpy(values, indices.data(), indices.size() * 4);
  return out;
}

Result<std::vector<std::byte>> to_dense(std::span<const std::byte> chunk, TensorSpec* spec_out) {
  const auto header = read_tensor_chunk(chunk);
  if (!header) return header.error();
  if (header->format != Format::Sparse)
    return invalid("a tensor is not sparse", std::string(name_of(header->format)), "sparse");
  constexpr uint64_t kDenseLimit = uint64_t{1} << 32;  // a small header must not cost all memory
  if (*header->spec.bytes() > kDenseLimit)
    return Error{Code::LIMIT_EXCEEDED,
                 "a sparse tensor is too big to be made dense",
                 header->spec.to_string(),
                 "at most 4 GiB",
                 "",
                 ""};
  const size_t size = size_of(header->spec.type);
  const size_t nnz = header->nonzero_count;
  const uint64_t count = *header->spec.shape.count();
  const std::byte* values = chunk.data() + kTensorHeaderBytes;
  const std::byte* indices = values + nnz * size;
  std::vector<std::byte> dense(static_cast<size_t>(*header->spec.bytes()));
  int64_t previous = -1;
  for (size_t i = 0; i < nnz; ++i) {
    uint32_t index;
    std::memcpy(&index, indices + 4 * i, 4);
    if (index >= count || int64_t{index} <= previous)
      return invalid("a sparse tensor has a bad index", std::to_string(index),
                     "ascending indices below " + std::to_string(count));
    std::memcpy(dense.data() + index * size, values + i * size, size);
    previous = index;
  }
  if (spec_out) *spec_out = header->spec;
  return dense;
}

}  // namespace weir
