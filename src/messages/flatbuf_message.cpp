// FlatBuffers messages by the FlatBuffers library. The library builds everything but the bytes of
// the tensors, which follow as vectors that the tables then point to: each byte is copied once, to
// its place.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "messages/flatbuf_message.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "tensors_generated.h"

static_assert(std::endian::native == std::endian::little, "FlatBuffers are little-endian");

namespace weir::messages {
namespace {

namespace schema = nnstreamer::flatbuf;

constexpr size_t kAlignment = 64;   // of each tensor in a message
constexpr size_t kLengthBytes = 4;  // in front of a vector

// The place of the first byte of a vector whose length begins at `at` or later.
size_t data_after(size_t at) {
  return (at + kLengthBytes + kAlignment - 1) / kAlignment * kAlignment;
}

flatbuffers::Offset<schema::Tensors> make_tables(const TensorMessage& message,
                                                 flatbuffers::FlatBufferBuilder* builder) {
  // Shared by all tensors; the empty data is replaced.
  const auto no_name = builder->CreateString("");
  const auto no_data = builder->CreateVector(static_cast<const uint8_t*>(nullptr), 0);
  std::vector<flatbuffers::Offset<schema::Tensor>> tensors;
  tensors.reserve(message.tensors.size());
  for (const auto& tensor : message.tensors) {
    const auto dimensions =
        builder->CreateVector(tensor.dimensions.data(), tensor.dimensions.size());
    tensors.push_back(schema::CreateTensor(
        *builder, no_name, static_cast<schema::Tensor_type>(tensor.type), dimensions, no_data));
  }
  const schema::frame_rate rate(message.rate_n, message.rate_d);
  return schema::CreateTensors(*builder, static_cast<int32_t>(tensors.size()), &rate,
                               builder->CreateVector(tensors),
                               static_cast<schema::Tensor_format>(message.format));
}

Error not_flatbuf(const char* what, size_t bytes) {
  return damaged_message(FlatbufMessage::kName, what, std::to_string(bytes) + " bytes",
                         "one message nnstreamer.flatbuf.Tensors in each buffer");
}

Status read_tensor(const schema::Tensor& from, MessageTensor* out) {
  out->type = static_cast<uint32_t>(from.type());
  const auto* dimensions = from.dimension();
  const size_t rank = dimensions ? dimensions->size() : 0;
  if (rank > out->dimensions.size())
    return damaged_message(FlatbufMessage::kName, "a tensor has too many dimensions",
                           std::to_string(rank), "at most 16");
  if (rank == out->dimensions.size())  // as most writers have it: a copy without a loop
    std::memcpy(out->dimensions.data(), dimensions->Data(), sizeof out->dimensions);
  else if (rank > 0)
    std::copy(dimensions->begin(), dimensions->end(), out->dimensions.begin());
  if (const auto* content = from.data())
    out->data = std::as_bytes(std::span(content->data(), content->size()));
  return ok();
}

}  // namespace

struct FlatbufMessage::Room {
  flatbuffers::FlatBufferBuilder builder;
  std::vector<uint64_t> copy;
};

FlatbufMessage::FlatbufMessage() : room_(std::make_unique<Room>()) {}
FlatbufMessage::FlatbufMessage(FlatbufMessage&&) noexcept = default;
FlatbufMessage::~FlatbufMessage() = default;

Status FlatbufMessage::write(const TensorMessage& message, const ReserveBytes& reserve) {
  auto& builder = room_->builder;
  builder.Clear();
  builder.Finish(make_tables(message, &builder));
  uint64_t total = builder.GetSize();
  for (const auto& tensor : message.tensors) {
    total = data_after(total) + tensor.data.size();
    if (auto status = check_size(kName, total); !status) return status;
  }
  auto* const out = reinterpret_cast<uint8_t*>(reserve(static_cast<size_t>(total)));
  size_t at = builder.GetSize();
  std::memcpy(out, builder.GetBufferPointer(), at);
  using Tables = flatbuffers::Vector<flatbuffers::Offset<flatbuffers::Table>>;
  auto* const tables = flatbuffers::GetMutableRoot<flatbuffers::Table>(out)->GetPointer<Tables*>(
      schema::Tensors::VT_TENSOR);
  for (size_t i = 0; i < message.tensors.size(); ++i) {
    const auto data = message.tensors[i].data;
    const size_t begin = data_after(at), length_at = begin - kLengthBytes;
    std::memset(out + at, 0, length_at - at);
    flatbuffers::WriteScalar(out + length_at, static_cast<uint32_t>(data.size()));
    if (!data.empty()) std::memcpy(out + begin, data.data(), data.size());
    auto* const table = tables->GetMutableObject(static_cast<flatbuffers::uoffset_t>(i));
    table->SetPointer(schema::Tensor::VT_DATA, out + length_at);
    at = begin + data.size();
  }
  return ok();
}

Status FlatbufMessage::parse(std::span<const std::byte> bytes, TensorMessage* message) {
  message->clear();
  if (auto status = check_size(kName, bytes.size()); !status) return status;
  if (reinterpret_cast<uintptr_t>(bytes.data()) % alignof(uint64_t) != 0) {
    room_->copy.resize(bytes.size() / sizeof(uint64_t) + 1);
    std::memcpy(room_->copy.data(), bytes.data(), bytes.size());
    bytes = std::as_bytes(std::span(room_->copy)).first(bytes.size());
  }
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  // Four times as many tables as there may be: too many tensors get an error of their own.
  flatbuffers::Verifier verifier(data, bytes.size(), 8, 4 * WEIR_TENSOR_LIMIT);
  if (bytes.size() < 2 * sizeof(uint32_t) || !schema::VerifyTensorsBuffer(verifier))
    return not_flatbuf("its tables cannot be read", bytes.size());
  const auto* root = schema::GetTensors(data);
  const auto* tensors = root->tensor();
  if (!tensors) return not_flatbuf("it has no tensors", bytes.size());
  if (tensors->size() > WEIR_TENSOR_LIMIT) return too_many_tensors(kName, tensors->size());
  if (const auto* rate = root->fr()) {
    message->rate_n = rate->rate_n();
    message->rate_d = rate->rate_d();
  }
  message->format = static_cast<uint32_t>(root->format());
  for (const auto* from : *tensors) {
    auto& tensor = message->tensors.emplace_back(kNoTensor);
    if (auto status = read_tensor(*from, &tensor); !status) return status;
  }
  return check_message(kName, static_cast<uint32_t>(root->num_tensor()), bytes.size(), *message);
}

}  // namespace weir::messages
