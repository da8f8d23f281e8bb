// FlexBuffers messages. The library builds them in the order in which NNStreamer does, so that
// programs that compare bytes find the same ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flexbuf_message.hpp"

#include <flatbuffers/flexbuffers.h>

#include <charconv>
#include <cstring>
#include <string_view>

#include "messages/flex_value.hpp"
#include "weir/module.hpp"

namespace weir::messages {
namespace {

constexpr size_t kParts = 4;  // of a tensor: name, type, dimensions, data

std::string make_key(size_t index) {
  return "tensor_" + std::to_string(index);
}

void build(const TensorMessage& message, flexbuffers::Builder* builder) {
  builder->Clear();
  builder->Map([&] {
    builder->UInt("num_tensors", message.tensors.size());
    builder->Int("rate_n", message.rate_n);
    builder->Int("rate_d", message.rate_d);
    builder->Int("format", message.format);
    for (size_t i = 0; i < message.tensors.size(); ++i) {
      const auto& tensor = message.tensors[i];
      builder->Vector(make_key(i).c_str(), [&] {
        builder->String("");
        builder->Int(tensor.type);
        builder->Vector(tensor.dimensions.data(), tensor.dimensions.size());
        builder->Blob(tensor.data.data(), tensor.data.size());
      });
    }
  });
  builder->Finish();
}

Error not_flexbuf(std::string what, size_t bytes) {
  return damaged_message(FlexbufMessage::kName, std::move(what), std::to_string(bytes) + " bytes",
                         "one map of num_tensors, rate_n, rate_d, format and tensor_0, "
                         "tensor_1, ... in each buffer");
}

// "tensor_12" is 12.
std::optional<uint32_t> parse_tensor_index(std::string_view key) {
  constexpr std::string_view kPrefix = "tensor_";
  if (!key.starts_with(kPrefix)) return {};
  key.remove_prefix(kPrefix.size());
  if (key.empty() || (key[0] == '0' && key.size() > 1)) return {};
  uint32_t index = 0;  // unsigned: takes no sign
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  if (end != key.data() + key.size() || error == std::errc::invalid_argument) return {};
  return error == std::errc() ? index : uint32_t{UINT32_MAX};
}

bool read_tensor(const FlexValue& value, MessageTensor* tensor) {
  const auto parts = value.elements();
  if (value.is_map() || !parts || parts->size() < kParts) return false;
  const auto type = parts->at(1).integer();
  const auto vector = parts->at(2);
  const auto dimensions = vector.elements();
  const auto data = parts->at(3).blob();
  if (!type || vector.is_map() || !dimensions || !data ||
      dimensions->size() > tensor->dimensions.size())
    return false;
  tensor->type =
      *type < 0 || *type > WEIR_TYPE_END ? uint32_t{WEIR_TYPE_END} : static_cast<uint32_t>(*type);
  tensor->data = *data;
  return dimensions->copy_to(tensor->dimensions);
}

bool read_int32(const FlexValue& value, int32_t* out) {
  const auto number = value.integer();
  if (!number || *number < INT32_MIN || *number > INT32_MAX) return false;
  *out = static_cast<int32_t>(*number);
  return true;
}

struct Header {
  int32_t num_tensors = 0, rate_n = 0, rate_d = 0, format = 0;
};
// Other keys are ignored.
bool read_number(const FlexValue& value, std::string_view key, Header* out) {
  if (key == "num_tensors") return read_int32(value, &out->num_tensors);
  if (key == "rate_n") return read_int32(value, &out->rate_n);
  if (key == "rate_d") return read_int32(value, &out->rate_d);
  return key != "format" || read_int32(value, &out->format);
}

bool read_tensor(const FlexValue& value, size_t index, TensorMessage* out) {
  if (out->tensors.size() <= index) out->tensors.resize(index + 1, kNoTensor);
  return read_tensor(value, &out->tensors[index]);
}

Status read_entries(const FlexElements& entries, size_t bytes, TensorMessage* message,
                    Header* header) {
  size_t found = 0;
  for (size_t i = 0; i < entries.size(); ++i) {
    const auto key = entries.key_at(i);
    if (!key) return not_flexbuf("a key cannot be read", bytes);
    const FlexValue value = entries.at(i);
    const auto index = parse_tensor_index(*key);
    if (index && *index >= WEIR_TENSOR_LIMIT)
      return too_many_tensors(FlexbufMessage::kName, uint64_t{*index} + 1);
    found += size_t{index.has_value()};
    if (!(index ? read_tensor(value, *index, message) : read_number(value, *key, header)))
      return not_flexbuf(std::string(*key) + " cannot be read", bytes);
  }
  return found == message->tensors.size()
             ? ok()
             : not_flexbuf("its tensors are not numbered from 0", bytes);
}

// Python's library puts the number of elements, not of bytes, in front of the blob of an array.
void take_length_for_elements(std::span<const std::byte> message, MessageTensor* tensor) {
  const size_t width = element_bytes(tensor->type);
  const auto bytes = count_bytes(*tensor);
  const auto left = static_cast<size_t>(message.data() + message.size() - tensor->data.data());
  if (width > 1 && bytes && tensor->data.size() == *bytes / width && *bytes <= left)
    tensor->data = {tensor->data.data(), static_cast<size_t>(*bytes)};
}

void take_lengths_for_elements(std::span<const std::byte> message,
                               std::vector<MessageTensor>* tensors) {
  for (auto& tensor : *tensors) take_length_for_elements(message, &tensor);
}

}  // namespace

struct FlexbufMessage::Room {
  flexbuffers::Builder builder;
};

FlexbufMessage::FlexbufMessage() : room_(std::make_unique<Room>()) {}
FlexbufMessage::FlexbufMessage(FlexbufMessage&&) noexcept = default;
FlexbufMessage::~FlexbufMessage() = default;

Status FlexbufMessage::write(const TensorMessage& message, const ReserveBytes& reserve) {
  uint64_t total = 0;
  for (const auto& tensor : message.tensors) total += tensor.data.size();
  if (auto status = check_size(kName, total); !status) return status;
  build(message, &room_->builder);
  const auto& built = room_->builder.GetBuffer();
  if (auto status = check_size(kName, built.size()); !status) return status;
  std::memcpy(reserve(built.size()), built.data(), built.size());
  return ok();
}

Status FlexbufMessage::parse(std::span<const std::byte> bytes, TensorMessage* message) {
  message->clear();
  if (auto status = check_size(kName, bytes.size()); !status) return status;
  const auto map = FlexValue::root(bytes);
  const auto entries = map && map->is_map() ? map->elements() : std::nullopt;
  if (!entries) return not_flexbuf("its map cannot be read", bytes.size());
  Header header;
  if (auto status = read_entries(*entries, bytes.size(), message, &header); !status) return status;
  if (header.format == kStatic) take_lengths_for_elements(bytes, &message->tensors);
  message->rate_n = header.rate_n;
  message->rate_d = header.rate_d;
  message->format = static_cast<uint32_t>(header.format);
  return check_message(kName, static_cast<uint32_t>(header.num_tensors), bytes.size(), *message);
}

}  // namespace weir::messages
