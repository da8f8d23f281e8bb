// protobuf messages by the coded streams of libprotobuf-lite. The generated classes would copy the
// bytes of each tensor twice.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/protobuf_message.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <cstring>

namespace weir::messages {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

constexpr uint32_t tag(int field, WireFormatLite::WireType type) {
  return static_cast<uint32_t>(field) << 3 | static_cast<uint32_t>(type);
}
constexpr auto kVarint = WireFormatLite::WIRETYPE_VARINT;
constexpr auto kBytes = WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
// Tensors
constexpr uint32_t kCount = tag(1, kVarint), kRate = tag(2, kBytes), kTensor = tag(3, kBytes),
                   kFormat = tag(4, kVarint);
// Tensors.frame_rate
constexpr uint32_t kNumerator = tag(1, kVarint), kDenominator = tag(2, kVarint);
// Tensor
constexpr uint32_t kType = tag(2, kVarint), kDimension = tag(3, kVarint),
                   kDimensions = tag(3, kBytes), kData = tag(4, kBytes);

size_t varint_size(uint64_t value) {
  return CodedOutputStream::VarintSize64(value);
}
// proto3 leaves out zeros; a negative int32 is written as 64 bits.
uint64_t extended(int32_t value) {
  return static_cast<uint64_t>(static_cast<int64_t>(value));
}
size_t field_size(uint64_t value) {
  return value == 0 ? 0 : 1 + varint_size(value);
}
uint8_t* write_field(uint32_t field, uint64_t value, uint8_t* to) {
  if (value == 0) return to;
  return CodedOutputStream::WriteVarint64ToArray(value,
                                                 CodedOutputStream::WriteTagToArray(field, to));
}
uint8_t* write_length(uint32_t field, size_t length, uint8_t* to) {
  return CodedOutputStream::WriteVarint32ToArray(static_cast<uint32_t>(length),
                                                 CodedOutputStream::WriteTagToArray(field, to));
}

size_t rate_size(const TensorMessage& message) {
  return field_size(extended(message.rate_n)) + field_size(extended(message.rate_d));
}
size_t dimensions_size(const MessageTensor& tensor) {
  size_t size = 0;
  for (const uint32_t d : tensor.dimensions) size += varint_size(d);
  return size;
}

// One message: its fields, never beyond its end.
class Fields {
 public:
  explicit Fields(std::span<const std::byte> bytes)
      : in_(reinterpret_cast<const uint8_t*>(bytes.data()), static_cast<int>(bytes.size())) {}

  // False at the end, and after damage.
  bool next(uint32_t* tag) {
    *tag = good_ ? in_.ReadTag() : 0;
    if (*tag == 0) good_ = good_ && in_.ConsumedEntireMessage();
    return *tag != 0;
  }
  bool good() const { return good_; }
  void skip(uint32_t tag) { good_ = WireFormatLite::SkipField(&in_, tag); }
  uint64_t number() {
    uint64_t value = 0;
    good_ = in_.ReadVarint64(&value);
    return value;
  }
  std::span<const std::byte> bytes() {
    uint32_t length = 0;
    const void* data = nullptr;
    int readable = 0;
    good_ = in_.ReadVarint32(&length);
    if (!good_ || length == 0) return {};
    in_.GetDirectBufferPointerInline(&data, &readable);
    good_ = readable > 0 && length <= static_cast<uint32_t>(readable);
    if (!good_) return {};
    in_.Skip(static_cast<int>(length));
    return {static_cast<const std::byte*>(data), length};
  }

 private:
  CodedInputStream in_;
  bool good_ = true;
};

// Appends one dimension; false when there are too many, or one is beyond 32 bits.
bool add_dimension(uint64_t value, size_t* count, MessageTensor* tensor) {
  if (*count == tensor->dimensions.size() || value > UINT32_MAX) return false;
  tensor->dimensions[(*count)++] = static_cast<uint32_t>(value);
  return true;
}

bool add_packed(std::span<const std::byte> packed, size_t* count, MessageTensor* tensor) {
  CodedInputStream in(reinterpret_cast<const uint8_t*>(packed.data()),
                      static_cast<int>(packed.size()));
  for (uint64_t value = 0; static_cast<size_t>(in.CurrentPosition()) < packed.size();)
    if (!in.ReadVarint64(&value) || !add_dimension(value, count, tensor)) return false;
  return true;
}

bool read_tensor(std::span<const std::byte> bytes, MessageTensor* tensor) {
  Fields fields(bytes);
  size_t dimensions = 0;
  tensor->type = WEIR_INT32;  // the default of proto3
  bool fits = true;
  for (uint32_t tag = 0; fits && fields.next(&tag);) switch (tag) {
      case kType:
        tensor->type = static_cast<uint32_t>(std::min<uint64_t>(fields.number(), UINT32_MAX));
        break;
      case kDimension:
        fits = add_dimension(fields.number(), &dimensions, tensor);
        break;
      case kDimensions:
        fits = add_packed(fields.bytes(), &dimensions, tensor);
        break;
      case kData:
        tensor->data = fields.bytes();
        break;
      default:
        fields.skip(tag);
    }
  return fits && fields.good();
}

bool read_rate(std::span<const std::byte> bytes, TensorMessage* message) {
  Fields fields(bytes);
  for (uint32_t tag = 0; fields.next(&tag);) {
    if (tag == kNumerator)
      message->rate_n = static_cast<int32_t>(fields.number());
    else if (tag == kDenominator)
      message->rate_d = static_cast<int32_t>(fields.number());
    else
      fields.skip(tag);
  }
  return fields.good();
}

uint8_t* write_tensor(const MessageTensor& tensor, size_t size, uint8_t* to) {
  to = write_length(kTensor, size, to);
  to = write_field(kType, tensor.type, to);
  to = write_length(kDimensions, dimensions_size(tensor), to);
  for (const uint32_t d : tensor.dimensions) to = CodedOutputStream::WriteVarint32ToArray(d, to);
  if (tensor.data.empty()) return to;
  to = write_length(kData, tensor.data.size(), to);
  std::memcpy(to, tensor.data.data(), tensor.data.size());
  return to + tensor.data.size();
}

}  // namespace

Status ProtobufMessage::write(const TensorMessage& message, const ReserveBytes& reserve) {
  const size_t rate = rate_size(message);
  uint64_t total = field_size(message.tensors.size()) + 1 + varint_size(rate) + rate +
                   field_size(message.format);
  sizes_.clear();
  for (const auto& tensor : message.tensors) {
    const size_t dimensions = dimensions_size(tensor), data = tensor.data.size();
    if (auto status = check_size(kName, total + data); !status) return status;
    const size_t size = field_size(tensor.type) + 1 + varint_size(dimensions) + dimensions +
                        (data == 0 ? 0 : 1 + varint_size(data) + data);
    sizes_.push_back(size);
    total += 1 + varint_size(size) + size;
  }
  if (auto status = check_size(kName, total); !status) return status;
  auto* to = reinterpret_cast<uint8_t*>(reserve(static_cast<size_t>(total)));
  to = write_field(kCount, message.tensors.size(), to);
  to = write_length(kRate, rate, to);
  to = write_field(kNumerator, extended(message.rate_n), to);
  to = write_field(kDenominator, extended(message.rate_d), to);
  for (size_t i = 0; i < sizes_.size(); ++i) to = write_tensor(message.tensors[i], sizes_[i], to);
  write_field(kFormat, message.format, to);
  return ok();
}

Status ProtobufMessage::parse(std::span<const std::byte> bytes, TensorMessage* message) {
  message->clear();
  if (auto status = check_size(kName, bytes.size()); !status) return status;
  Fields fields(bytes);
  uint64_t count = 0, seen = 0;
  bool good = true;
  for (uint32_t tag = 0; good && fields.next(&tag);) switch (tag) {
      case kCount:
        count = fields.number();
        break;
      case kRate:
        good = read_rate(fields.bytes(), message);
        break;
      case kTensor: {
        const auto tensor = fields.bytes();
        if (++seen > WEIR_TENSOR_LIMIT) break;  // counted for the error
        good = read_tensor(tensor, &message->tensors.emplace_back(kNoTensor));
        break;
      }
      case kFormat:
        message->format = static_cast<uint32_t>(std::min<uint64_t>(fields.number(), UINT32_MAX));
        break;
      default:
        fields.skip(tag);
    }
  if (!good || !fields.good())
    return damaged_message(kName, "its fields cannot be read",
                           std::to_string(bytes.size()) + " bytes",
                           "one message nnstreamer.protobuf.Tensors in each buffer");
  if (seen > WEIR_TENSOR_LIMIT) return too_many_tensors(kName, seen);
  return check_message(kName, count, bytes.size(), *message);
}

}  // namespace weir::messages
