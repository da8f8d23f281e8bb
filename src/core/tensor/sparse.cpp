// Dense <-> sparse (specification 1.8).
#include "core/tensor/sparse.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

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
T element(std::span<const std::byte> dense, size_t index) noexcept {
  T value;
  std::memcpy(&value, dense.data() + index * sizeof(T), sizeof(T));
  return value;
}

// The highest bit of each lane of eight bytes.
template <class T>
constexpr uint64_t highest_bits() {
  uint64_t out = 0;
  for (size_t i = 1; i <= 8 / sizeof(T); ++i) out |= uint64_t{1} << (8 * sizeof(T) * i - 1);
  return out;
}

// The highest bit of each lane that is not zero: such a lane carries into it. The sign of a
// floating point number does not make it other than zero.
template <class T>
uint64_t nonzero_lanes(const std::byte* at) noexcept {
  constexpr uint64_t kHigh = highest_bits<T>();
  constexpr bool kSigned = std::is_floating_point_v<T> || std::is_same_v<T, float16>;
  uint64_t word;
  std::memcpy(&word, at, 8);
  return (((word & ~kHigh) + ~kHigh) | (kSigned ? 0 : word)) & kHigh;
}

template <class T>
uint32_t count_nonzero(std::span<const std::byte> dense) noexcept {
  constexpr size_t kBits = 8 * sizeof(T), kStep = 8 / sizeof(T);
  constexpr size_t kWordsInARow = 255;  // as many ones a lane of one byte can count
  const size_t count = dense.size() / sizeof(T), words = count / kStep;
  uint64_t nonzero = 0;
  for (size_t begin = 0; begin < words; begin += kWordsInARow) {
    uint64_t lanes = 0;
    for (size_t i = begin; i < std::min(words, begin + kWordsInARow); ++i)
      lanes += nonzero_lanes<T>(dense.data() + 8 * i) >> (kBits - 1);
    for (size_t lane = 0; lane < kStep; ++lane)
      nonzero += lanes >> (kBits * lane) & (kBits < 64 ? (uint64_t{1} << kBits % 64) - 1 : ~0ull);
  }
  for (size_t i = words * kStep; i < count; ++i) nonzero += is_zero(element<T>(dense, i)) ? 0 : 1;
  return static_cast<uint32_t>(nonzero);
}

// Eight bytes in one step, of which only the elements that are not zero are looked at.
template <class T>
void write_elements(std::span<const std::byte> dense, size_t nonzero, std::byte* values,
                    std::byte* indices) noexcept {
  constexpr size_t kStep = 8 / sizeof(T);
  const size_t count = dense.size() / sizeof(T);
  size_t found = 0;
  const auto take = [&](size_t i) {
    const auto index = static_cast<uint32_t>(i);
    std::memcpy(values + found * sizeof(T), dense.data() + i * sizeof(T), sizeof(T));
    std::memcpy(indices + found * 4, &index, 4);
    ++found;
  };
  size_t i = 0;
  for (; i + kStep <= count; i += kStep) {
    uint64_t lanes = nonzero_lanes<T>(dense.data() + i * sizeof(T));
    for (; lanes != 0 && found < nonzero; lanes &= lanes - 1)
      take(i + static_cast<size_t>(std::countr_zero(lanes)) / (8 * sizeof(T)));
  }
  for (; i < count && found < nonzero; ++i)
    if (!is_zero(element<T>(dense, i))) take(i);
}

}  // namespace

Result<TensorHeader> sparse_header(const TensorSpec& spec, std::span<const std::byte> dense) {
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
  TensorHeader header;
  header.spec = spec;
  header.format = Format::Sparse;
  header.nonzero_count = visit_type(
      spec.type, [&]<class T>(std::type_identity<T>) { return count_nonzero<T>(dense); });
  return header;
}

void write_sparse(const TensorHeader& header, std::span<const std::byte> dense,
                  std::span<std::byte> out) noexcept {
  write_tensor_header(header, out.first<kTensorHeaderBytes>());
  std::byte* values = out.data() + kTensorHeaderBytes;
  std::byte* indices = values + size_t{header.nonzero_count} * size_of(header.spec.type);
  visit_type(header.spec.type, [&]<class T>(std::type_identity<T>) {
    write_elements<T>(dense, header.nonzero_count, values, indices);
  });
}

Result<TensorHeader> read_sparse_header(std::span<const std::byte> chunk) {
  auto header = read_tensor_chunk(chunk);
  if (!header) return header;
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
  return header;
}

Status read_sparse(const TensorHeader& header, std::span<const std::byte> chunk,
                   std::span<std::byte> dense) {
  const size_t size = size_of(header.spec.type), nonzero = header.nonzero_count;
  const uint64_t count = *header.spec.shape.count();
  const std::byte* values = chunk.data() + kTensorHeaderBytes;
  const std::byte* indices = values + nonzero * size;
  std::memset(dense.data(), 0, dense.size());
  return visit_type(header.spec.type, [&]<class T>(std::type_identity<T>) -> Status {
    uint64_t least = 0;
    for (size_t i = 0; i < nonzero; ++i) {
      uint32_t index;
      std::memcpy(&index, indices + 4 * i, 4);
      if (index >= count || index < least)
        return invalid("a sparse tensor has a bad index",
                       std::to_string(index) + " as index " + std::to_string(i),
                       "ascending indices below " + std::to_string(count));
      std::memcpy(dense.data() + index * sizeof(T), values + i * sizeof(T), sizeof(T));
      least = uint64_t{index} + 1;
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
