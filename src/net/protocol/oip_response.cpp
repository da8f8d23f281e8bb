// Parses answers of the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_messages.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

constexpr size_t kMaxTensors = WEIR_TENSOR_LIMIT;

Error damaged(const char* message) {
  return damaged_message(Sender::Server, message);
}

}  // namespace

Result<ModelMetadata> parse_model_metadata(const Chunks& chunks) {
  ModelMetadata out;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.name = reader.text(field, kMaxNameBytes);
    if (field.number == 3) out.platform = reader.text(field, kMaxNameBytes);
    if (field.number != 4 && field.number != 5) continue;
    auto& list = field.number == 4 ? out.inputs : out.outputs;
    if (list.size() == kMaxTensors || field.type != WireType::Bytes ||
        !read_tensor(chunks, field.range, &list.emplace_back(), nullptr))
      return damaged("ModelMetadataResponse");
  }
  if (reader.failed()) return damaged("ModelMetadataResponse");
  return out;
}

Result<bool> parse_has_extension(const Chunks& chunks, std::string_view extension) {
  bool found = false;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 3) found = reader.text(field, kMaxNameBytes) == extension || found;
  if (reader.failed()) return damaged("ServerMetadataResponse");
  return found;
}

Result<bool> parse_model_ready(const Chunks& chunks) {
  bool ready = false;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 1) ready = field.type == WireType::Varint && field.value != 0;
  if (reader.failed()) return damaged("ModelReadyResponse");
  return ready;
}

// The parameters of an answer that are times; the others have no meaning here.
class TimesReader {
 public:
  // False: the entry is damaged.
  bool read(const Chunks& chunks, Range entry) {
    std::string name;
    int64_t value = -1;
    FieldReader reader(chunks, entry);
    for (Field field; reader.next(&field);) {
      if (field.number == 1) name = reader.text(field, kMaxNameBytes);
      if (field.number != 2 || field.type != WireType::Bytes) continue;
      FieldReader choice(chunks, field.range);
      for (Field chosen; choice.next(&chosen);)
        if (chosen.number == 2 && chosen.type == WireType::Varint)
          value = static_cast<int64_t>(chosen.value);
      if (choice.failed()) return false;
    }
    for (size_t i = 0; i < kNames.size(); ++i)
      if (name == kNames[i]) found_[i] = value;
    return !reader.failed();
  }
  // nullopt unless all are there and can be: a peer may send any number.
  std::optional<AnswerTimes> times() const {
    constexpr int64_t kMaxNs = int64_t{1} << 62, kMaxUs = kMaxNs / 1000;
    const auto [received, answered, queue, compute] = found_;
    if (received < 0 || answered < received || answered > kMaxNs || queue < 0 || queue > kMaxUs ||
        compute < 0 || compute > kMaxUs)
      return std::nullopt;
    return AnswerTimes{received, answered, queue, compute};
  }

 private:
  static constexpr std::array<std::string_view, 4> kNames{"weir_received_ns", "weir_answered_ns",
                                                          "weir_queue_us", "weir_compute_us"};
  std::array<int64_t, 4> found_{-1, -1, -1, -1};
};

// Reads an output or raw contents of ModelInferResponse. False: the message is damaged.
bool read_infer_field(const Chunks& chunks, const Field& field, InferResponse* out) {
  if (field.number != 5 && field.number != 6) return true;
  if (field.type != WireType::Bytes) return false;
  if (field.number == 6) {
    if (out->raw.size() == kMaxTensors) return false;
    out->raw.push_back(field.range);
    return true;
  }
  if (out->outputs.size() == kMaxTensors) return false;
  auto& output = out->outputs.emplace_back();
  return read_tensor(chunks, field.range, &output, &output.contents);
}

Result<InferResponse> parse_infer_response(const Chunks& chunks) {
  InferResponse out;
  TimesReader times;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    const bool is_parameter = field.number == 4 && field.type == WireType::Bytes;
    if (is_parameter ? !times.read(chunks, field.range) : !read_infer_field(chunks, field, &out))
      return damaged("ModelInferResponse");
  }
  if (reader.failed()) return damaged("ModelInferResponse");
  out.times = times.times();
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
