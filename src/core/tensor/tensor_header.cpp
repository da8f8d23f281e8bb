// The 128-byte header (docs/compatibility/types-and-caps.md 1.7).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/tensor_header.hpp"

#include <algorithm>
#include <cstring>
#include <string>

namespace weir {
namespace {

constexpr uint32_t kMagic = 0xFEEDCCED;
constexpr uint32_t kVersion = 0xDE001000;  // 1.0
constexpr uint32_t kVersionTag = 0xDE;
enum Word {
  kMagicWord,
  kVersionWord,
  kTypeWord,
  kDimsWord,
  kFormatWord = 19,
  kMediaWord,
  kNnzWord,
  kEmptyWord,  // bit i: dimension i is 0
  kFirstWord
};

uint32_t word(std::span<const std::byte> bytes, size_t index) noexcept {
  uint32_t value;
  std::memcpy(&value, bytes.data() + 4 * index, 4);
  return value;
}
void put(std::span<std::byte, kTensorHeaderBytes> out, size_t index, uint32_t value) noexcept {
  std::memcpy(out.data() + 4 * index, &value, 4);
}

Error invalid_header(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::HEADER_INVALID,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "check the element or program that wrote the stream"};
}

// A tensor without elements: the first dimension is written as 0, which other readers of this
// format reject, and stands in kFirstWord. Dimensions of 0 are written as 1. False if not valid.
bool read_shape(std::span<const std::byte> bytes, Shape* shape) noexcept {
  for (size_t i = 0; i < kRankLimit; ++i) (*shape)[i] = word(bytes, kDimsWord + i);
  const uint32_t empty = word(bytes, kEmptyWord);
  if (empty == 0 || (*shape)[0] != 0) return shape->valid();
  (*shape)[0] = word(bytes, kFirstWord);
  if (!shape->valid()) return false;
  shape->set_rank(shape->rank());
  for (size_t i = 0; i < 32; ++i) {
    if (!((empty >> i) & 1)) continue;
    if (i >= shape->rank() || (*shape)[i] != 1) return false;
    (*shape)[i] = 0;
  }
  return true;
}

void write_shape(const Shape& shape, std::span<std::byte, kTensorHeaderBytes> out) noexcept {
  const bool is_empty = shape.is_empty();
  for (size_t i = is_empty ? 1 : 0; i < shape.rank(); ++i)
    put(out, kDimsWord + i, std::max(shape[i], 1u));
  if (!is_empty) return;
  uint32_t empty = 0;
  for (size_t i = 0; i < shape.rank(); ++i) empty |= shape[i] == 0 ? 1u << i : 0;
  put(out, kEmptyWord, empty);
  put(out, kFirstWord, std::max(shape[0], 1u));
}

Status check_sizes(const TensorHeader& header) {
  const auto count = header.spec.shape.count();
  if (!count || !header.spec.bytes() || !header.payload_bytes())
    return invalid_header("the dimensions of a tensor header overflow", header.spec.to_string(),
                          "a size below 2^63 bytes");
  if (header.format == Format::Sparse && header.nonzero_count > *count)
    return invalid_header("a sparse header has more values than the tensor has elements",
                          std::to_string(header.nonzero_count) + " values",
                          "at most " + std::to_string(*count));
  return ok();
}

}  // namespace

std::optional<uint64_t> TensorHeader::payload_bytes() const noexcept {
  if (!spec.valid()) return std::nullopt;
  if (format != Format::Sparse) return spec.bytes();
  return uint64_t{nonzero_count} * (element_size(spec.type) + 4);
}

Result<TensorHeader> read_tensor_header(std::span<const std::byte> bytes) {
  if (bytes.size() < kTensorHeaderBytes)
    return invalid_header("a memory is too short for a tensor header",
                          std::to_string(bytes.size()) + " bytes", "at least 128 bytes");
  if (word(bytes, kMagicWord) != kMagic)
    return invalid_header("a memory does not start with a tensor header",
                          "magic " + std::to_string(word(bytes, kMagicWord)), "magic 0xFEEDCCED");
  if (((word(bytes, kVersionWord) >> 24) & kVersionTag) != kVersionTag)
    return invalid_header("a tensor header has an unknown version",
                          std::to_string(word(bytes, kVersionWord)), "0xDE001000");
  const uint32_t type = word(bytes, kTypeWord);
  const uint32_t format = word(bytes, kFormatWord);
  const auto media = static_cast<int32_t>(word(bytes, kMediaWord));
  if (type >= static_cast<uint32_t>(ElementType::End))
    return invalid_header("a tensor header has an unknown element type", std::to_string(type),
                          "0 to 10");
  if (format >= static_cast<uint32_t>(Format::End))
    return invalid_header("a tensor header has an unknown format", std::to_string(format),
                          "0 to 2");
  if (media < static_cast<int32_t>(MediaType::Invalid) ||
      media > static_cast<int32_t>(MediaType::Tensor))
    return invalid_header("a tensor header has an unknown media type", std::to_string(media),
                          "0 to 4");
  TensorHeader header;
  header.spec.type = static_cast<ElementType>(type);
  if (!read_shape(bytes, &header.spec.shape))
    return invalid_header("a tensor header has bad dimensions",
                          "\"" + header.spec.shape.to_string() + "\"",
                          "numbers above 0, followed by zeros only");
  header.format = static_cast<Format>(format);
  if (header.format == Format::Sparse && header.spec.shape.is_empty())
    return invalid_header("a sparse tensor has no elements", header.spec.shape.to_string(),
                          "numbers above 0, followed by zeros only");
  header.media = static_cast<MediaType>(media);
  if (header.format == Format::Sparse) header.nonzero_count = word(bytes, kNnzWord);
  if (auto status = check_sizes(header); !status) return status.error();
  return header;
}

Result<TensorHeader> read_tensor_chunk(std::span<const std::byte> bytes) {
  auto header = read_tensor_header(bytes);
  if (!header) return header;
  const uint64_t needed = *header->payload_bytes();
  if (needed > bytes.size() - kTensorHeaderBytes)
    return invalid_header(
        "a tensor header declares more bytes than its memory holds",
        std::to_string(bytes.size() - kTensorHeaderBytes) + " bytes after the header",
        std::to_string(needed) + " bytes for " + header->spec.to_string());
  return header;
}

void write_tensor_header(const TensorHeader& header,
                         std::span<std::byte, kTensorHeaderBytes> out) noexcept {
  std::fill(out.begin(), out.end(), std::byte{0});
  put(out, kMagicWord, kMagic);
  put(out, kVersionWord, kVersion);
  put(out, kTypeWord, static_cast<uint32_t>(header.spec.type));
  write_shape(header.spec.shape, out);
  put(out, kFormatWord, static_cast<uint32_t>(header.format));
  put(out, kMediaWord, static_cast<uint32_t>(header.media));
  if (header.format == Format::Sparse) put(out, kNnzWord, header.nonzero_count);
}

}  // namespace weir
