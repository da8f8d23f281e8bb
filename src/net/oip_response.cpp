// Parses answers of the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/oip_contents.hpp"
#include "net/oip_messages.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

constexpr size_t kMostTensors = WEIR_TENSOR_LIMIT;

Error damaged(const char* message) {
  return damaged_message(Sender::Server, message);
}

}  // namespace

Result<ModelMetadata> parse_model_metadata(const Chunks& chunks) {
  ModelMetadata out;
  MessageReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.name = reader.text(field, kMostNameBytes);
    if (field.number == 3) out.platform = reader.text(field, kMostNameBytes);
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
    return bad_message(Sender::Server,
                       std::to_string(out.raw.size()) + " raw contents for " +
                           std::to_string(out.outputs.size()) + " outputs",
                       "one for each output");
  return out;
}

Status read_output(const Chunks& chunks, const InferResponse& response, size_t index,
                   std::span<std::byte> to) {
  const auto raw = response.raw.empty() ? std::nullopt : std::optional(response.raw[index]);
  return read_elements(chunks, response.outputs[index], raw, to, Sender::Server);
}

Result<Range> bytes_element(const Chunks& chunks, const InferResponse& response, size_t index) {
  const auto raw = response.raw.empty() ? std::nullopt : std::optional(response.raw[index]);
  return only_element(chunks, response.outputs[index], raw, Sender::Server);
}

}  // namespace weir::net
