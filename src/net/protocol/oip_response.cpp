// Parses responses of the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_messages.hpp"
#include "weir/module.hpp"

namespace weir::net {
Result<ModelMetadata> parse_model_metadata(const Chunks& chunks) {
  ModelMetadata out;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.name = reader.text(field, kMaxNameBytes);
    if (field.number == 3) out.platform = reader.text(field, kMaxNameBytes);
    if (field.number != 4 && field.number != 5) continue;
    auto& list = field.number == 4 ? out.inputs : out.outputs;
    if (list.size() == WEIR_TENSOR_LIMIT || field.type != WireType::Bytes ||
        !read_tensor(chunks, field.range, &list.emplace_back(), nullptr))
      return damaged_message(Sender::Server, "ModelMetadataResponse");
  }
  if (reader.failed()) return damaged_message(Sender::Server, "ModelMetadataResponse");
  return out;
}

Result<bool> parse_has_extension(const Chunks& chunks, std::string_view extension) {
  bool found = false;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 3) found = reader.text(field, kMaxNameBytes) == extension || found;
  if (reader.failed()) return damaged_message(Sender::Server, "ServerMetadataResponse");
  return found;
}

Result<bool> parse_model_ready(const Chunks& chunks) {
  bool ready = false;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 1) ready = field.type == WireType::Varint && field.value != 0;
  if (reader.failed()) return damaged_message(Sender::Server, "ModelReadyResponse");
  return ready;
}

// The parameters of a response that are times; the others have no meaning here.
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
  std::optional<ServerTimes> times() const {
    constexpr int64_t kMaxNs = int64_t{1} << 62, kMaxUs = kMaxNs / 1000;
    const auto [received, answered, queue, compute] = found_;
    if (received < 0 || answered < received || answered > kMaxNs || queue < 0 || queue > kMaxUs ||
        compute < 0 || compute > kMaxUs)
      return std::nullopt;
    return ServerTimes{received, answered, queue, compute};
  }

 private:
  static constexpr std::array<std::string_view, 4> kNames{"weir_received_ns", "weir_answered_ns",
                                                          "weir_queue_us", "weir_compute_us"};
  std::array<int64_t, 4> found_{-1, -1, -1, -1};
};

Result<InferResponse> parse_infer_response(const Chunks& chunks) {
  InferResponse out;
  TimesReader times;
  std::vector<Range> raw;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    const bool is_parameter = field.number == 4 && field.type == WireType::Bytes;
    if (is_parameter ? !times.read(chunks, field.range)
                     : !read_tensor_field(chunks, field, 6, &out.outputs, &raw))
      return damaged_message(Sender::Server, "ModelInferResponse");
  }
  if (reader.failed()) return damaged_message(Sender::Server, "ModelInferResponse");
  out.times = times.times();
  if (auto status = set_raw(raw, Sender::Server, &out.outputs); !status) return status.error();
  return out;
}

}  // namespace weir::net
