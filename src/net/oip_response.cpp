// Parses answers of the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "net/oip_messages.hpp"
#include "net/oip_types.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

constexpr size_t kMostTensors = WEIR_TENSOR_LIMIT, kMostName = 1024, kMostRanges = 4096;

Error bad_message(std::string offered, std::string needed) {
  return {.code = Code::PEER_MESSAGE_INVALID,
          .what = "a server sent a message that cannot be used",
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = "look at the server's log; another program may listen at this address"};
}

Error damaged(const char* message) {
  return bad_message(std::string("a damaged ") + message, "a message of the protocol");
}

// Adds the extents of a field `shape`, packed or not.
bool read_shape(const Chunks& chunks, const Field& field, std::vector<int64_t>* shape) {
  if (field.type == WireType::Varint) {
    shape->push_back(static_cast<int64_t>(field.value));
    return shape->size() <= WEIR_RANK_LIMIT;
  }
  if (field.type != WireType::Bytes) return false;
  for (Cursor cursor(chunks, field.range); !cursor.at_end();) {
    const auto extent = cursor.varint();
    if (!extent || shape->size() == WEIR_RANK_LIMIT) return false;
    shape->push_back(static_cast<int64_t>(*extent));
  }
  return true;
}

bool read_tensor(const Chunks& chunks, Range range, TensorText* out, std::vector<Range>* contents) {
  MessageReader reader(chunks, range);
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out->name = reader.text(field, kMostName);
    if (field.number == 2) out->datatype = reader.text(field, kMostName);
    if (field.number == 3 && !read_shape(chunks, field, &out->shape)) return false;
    if (field.number == 5 && contents) {
      if (field.type != WireType::Bytes || contents->size() == kMostRanges) return false;
      contents->push_back(field.range);
    }
  }
  return !reader.failed();
}

std::string describe_shape(const TensorText& tensor) {
  std::string out = tensor.name + " " + tensor.datatype + " [";
  for (const int64_t extent : tensor.shape)
    out += (out.back() == '[' ? "" : ",") + std::to_string(extent);
  return out + "]";
}

// Writes numbers one after the other into memory of a fixed size.
class NumberWriter {
 public:
  NumberWriter(const OipType& type, std::span<std::byte> to)
      : bytes_(element_bytes(type.type)), to_(to) {}
  bool put(uint64_t value) {
    if (used_ + bytes_ > to_.size()) return false;
    std::memcpy(to_.data() + used_, &value, bytes_);  // little-endian: the low bytes
    used_ += bytes_;
    return true;
  }
  bool full() const noexcept { return used_ == to_.size(); }

 private:
  const size_t bytes_;
  std::span<std::byte> to_;
  size_t used_ = 0;
};

// Reads one field of InferTensorContents: one number, or several packed.
bool read_numbers(const Chunks& chunks, const Field& field, size_t fixed_bytes, NumberWriter* to) {
  if (field.type != WireType::Bytes) {
    const bool fits = field.type == (fixed_bytes == 4   ? WireType::Fixed32
                                     : fixed_bytes == 8 ? WireType::Fixed64
                                                        : WireType::Varint);
    return fits && to->put(field.value);
  }
  for (Cursor cursor(chunks, field.range); !cursor.at_end();) {
    const auto value = fixed_bytes ? cursor.fixed(fixed_bytes) : cursor.varint();
    if (!value || !to->put(*value)) return false;
  }
  return true;
}

Status read_typed(const Chunks& chunks, const InferOutput& output, const OipType& type,
                  std::span<std::byte> to) {
  const size_t fixed_bytes = type.type == WEIR_FLOAT32 ? 4 : type.type == WEIR_FLOAT64 ? 8 : 0;
  NumberWriter writer(type, to);
  bool fits = type.content_field != 0;
  for (const Range range : output.contents) {
    MessageReader reader(chunks, range);
    for (Field field; fits && reader.next(&field);)
      if (field.number == type.content_field)
        fits = read_numbers(chunks, field, fixed_bytes, &writer);
    if (reader.failed()) return damaged("InferTensorContents");
  }
  if (fits && writer.full()) return ok();
  return bad_message("typed contents of another number of elements for " + describe_shape(output),
                     std::to_string(to.size()) + " bytes of elements");
}

}  // namespace

Result<ModelMetadata> parse_model_metadata(const Chunks& chunks) {
  ModelMetadata out;
  MessageReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.name = reader.text(field, kMostName);
    if (field.number == 3) out.platform = reader.text(field, kMostName);
    if (field.number != 4 && field.number != 5) continue;
    auto& list = field.number == 4 ? out.inputs : out.outputs;
    if (list.size() == kMostTensors || field.type != WireType::Bytes ||
        !read_tensor(chunks, field.range, &list.emplace_back(), nullptr))
      return damaged("ModelMetadataResponse");
  }
  if (reader.failed()) return damaged("ModelMetadataResponse");
  return out;
}

Result<bool> parse_model_ready(const Chunks& chunks) {
  bool ready = false;
  MessageReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 1) ready = field.type == WireType::Varint && field.value != 0;
  if (reader.failed()) return damaged("ModelReadyResponse");
  return ready;
}

// Of ModelInferResponse: its outputs and raw contents. False: the message is damaged.
bool read_infer_field(const Chunks& chunks, const Field& field, InferResponse* out) {
  if (field.number != 5 && field.number != 6) return true;
  if (field.type != WireType::Bytes) return false;
  if (field.number == 6) {
    if (out->raw.size() == kMostTensors) return false;
    out->raw.push_back(field.range);
    return true;
  }
  if (out->outputs.size() == kMostTensors) return false;
  auto& output = out->outputs.emplace_back();
  return read_tensor(chunks, field.range, &output, &output.contents);
}

Result<InferResponse> parse_infer_response(const Chunks& chunks) {
  InferResponse out;
  MessageReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (!read_infer_field(chunks, field, &out)) return damaged("ModelInferResponse");
  if (reader.failed()) return damaged("ModelInferResponse");
  if (!out.raw.empty() && out.raw.size() != out.outputs.size())
    return bad_message(std::to_string(out.raw.size()) + " raw contents for " +
                           std::to_string(out.outputs.size()) + " outputs",
                       "one for each output");
  return out;
}

Status read_output(const Chunks& chunks, const InferResponse& response, size_t index,
                   std::span<std::byte> to) {
  const InferOutput& output = response.outputs[index];
  const auto* type = oip_type(output.datatype);
  if (!type) return bad_message(describe_shape(output), "a type of streams");
  if (response.raw.empty()) return read_typed(chunks, output, *type, to);
  const Range raw = response.raw[index];
  if (raw.size() != to.size())
    return bad_message(std::to_string(raw.size()) + " bytes for " + describe_shape(output),
                       std::to_string(to.size()) + " bytes");
  chunks.copy(raw, to.data());
  return ok();
}

Result<Range> bytes_element(const Chunks& chunks, const InferResponse& response, size_t index) {
  const InferOutput& output = response.outputs[index];
  const auto other = [&] {
    return bad_message("BYTES of other than one element for " + describe_shape(output),
                       "one element");
  };
  if (!response.raw.empty()) {
    const Range raw = response.raw[index];
    const auto length = Cursor(chunks, raw).fixed(4);
    if (!length || *length != raw.size() - 4) return other();
    return Range{raw.begin + 4, raw.end};
  }
  std::vector<Range> found;
  for (const Range range : output.contents) {
    MessageReader reader(chunks, range);
    for (Field field; reader.next(&field);)
      if (field.number == 8 && field.type == WireType::Bytes && found.size() < 2)
        found.push_back(field.range);
    if (reader.failed()) return damaged("InferTensorContents");
  }
  if (found.size() != 1) return other();
  return found.front();
}

}  // namespace weir::net
