// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_service_messages.hpp"

#include "net/protocol/oip_contents.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

// The name in an InferRequestedOutputTensor.
bool read_output_name(const Chunks& chunks, Range range, std::string* out) {
  FieldReader reader(chunks, range);
  for (Field field; reader.next(&field);)
    if (field.number == 1) *out = reader.text(field, kMaxNameBytes);
  return !reader.failed();
}

// Whether an entry of the parameters is weir_times with the value true.
bool asks_for_times(const Chunks& chunks, Range entry) {
  constexpr std::string_view kName = kTimesExtension;
  bool named = false, is_true = false;
  FieldReader reader(chunks, entry);
  for (Field field; reader.next(&field);) {
    if (field.number == 1)
      named = field.range.size() == kName.size() && reader.text(field, kName.size()) == kName;
    if (field.number != 2 || field.type != WireType::Bytes) continue;
    FieldReader value(chunks, field.range);
    for (Field choice; value.next(&choice);)
      is_true = choice.number == 1 && choice.type == WireType::Varint && choice.value != 0;
  }
  return named && is_true && !reader.failed();
}

void put_parameter(std::string* to, std::string_view name, int64_t value) {
  std::string choice, entry;
  put_varint(&choice, 2 << 3);  // int64_param: also 0 is written, as the choice
  put_varint(&choice, static_cast<uint64_t>(value));
  put_bytes(&entry, 1, name);
  put_bytes(&entry, 2, choice);
  put_bytes(to, 4, entry);
}

void put_duration(std::string* to, uint32_t field, const Duration& duration) {
  std::string out;
  put_number(&out, 1, duration.count);
  put_number(&out, 2, duration.ns);
  put_bytes(to, field, out);
}

std::string encode_model_statistics(const ModelStatistics& model) {
  std::string times, out;
  put_duration(&times, 1, model.success);
  put_duration(&times, 2, model.fail);
  put_duration(&times, 3, model.queue);
  put_duration(&times, 4, model.compute_input);
  put_duration(&times, 5, model.compute_infer);
  put_duration(&times, 6, model.compute_output);
  put_text(&out, 1, model.model.name);
  put_text(&out, 2, model.model.version);
  put_number(&out, 3, model.last_inference_ms);
  put_number(&out, 4, model.inferences);
  put_number(&out, 5, model.executions);
  put_bytes(&out, 6, times);
  return out;
}

}  // namespace

std::string describe(const ModelRequest& model) {
  return model.version.empty() ? model.name : model.name + " version " + model.version;
}

bool fits(const ModelRequest& wanted, const ModelRequest& served) {
  return wanted.name == served.name && (wanted.version.empty() || wanted.version == served.version);
}

Result<ModelRequest> parse_model_request(const Chunks& chunks) {
  ModelRequest out;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.name = reader.text(field, kMaxNameBytes);
    if (field.number == 2) out.version = reader.text(field, kMaxNameBytes);
  }
  if (reader.failed()) return damaged_message(Sender::Client, "request for a model");
  return out;
}

Result<LoadRequest> parse_load_request(const Chunks& chunks) {
  LoadRequest out;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 2) out.model = reader.text(field, kMaxNameBytes);
    if (field.number == 3) out.has_parameters = true;
  }
  if (reader.failed()) return damaged_message(Sender::Client, "request to load a model");
  return out;
}

Result<bool> parse_index_request(const Chunks& chunks) {
  bool ready = false;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);)
    if (field.number == 2) ready = field.value != 0;
  if (reader.failed()) return damaged_message(Sender::Client, "RepositoryIndexRequest");
  return ready;
}

Result<InferRequest> parse_infer_request(const Chunks& chunks) {
  InferRequest out;
  std::vector<Range> raw;
  FieldReader reader(chunks, {0, chunks.size()});
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out.model = reader.text(field, kMaxNameBytes);
    if (field.number == 2) out.version = reader.text(field, kMaxNameBytes);
    if (field.number == 3) out.id = reader.text(field, kMaxNameBytes);
    if (field.number == 4 && field.type == WireType::Bytes)
      out.wants_times = asks_for_times(chunks, field.range) || out.wants_times;
    const bool is_read =
        field.number == 6
            ? field.type == WireType::Bytes && out.outputs.size() < WEIR_TENSOR_LIMIT &&
                  read_output_name(chunks, field.range, &out.outputs.emplace_back())
            : read_tensor_field(chunks, field, 7, &out.inputs, &raw);
    if (!is_read) return damaged_message(Sender::Client, "ModelInferRequest");
  }
  if (reader.failed()) return damaged_message(Sender::Client, "ModelInferRequest");
  if (auto status = set_raw(raw, Sender::Client, &out.inputs); !status) return status.error();
  for (const auto& input : out.inputs)
    if (input.raw && !input.contents.empty())
      return bad_message(Sender::Client,
                         "raw contents for all inputs, and typed contents for " + describe(input),
                         "either raw contents of all inputs or typed contents of all");
  return out;
}

Result<std::string> parse_health_request(const Chunks& chunks) {
  auto request = parse_model_request(chunks);
  if (!request) return request.error();
  return std::move(request->name);
}

Pieces encode_flag(bool value) {
  std::string out;
  put_number(&out, 1, value ? 1 : 0);
  return {{std::move(out), {}}};
}

Pieces encode_server_metadata(std::string_view name, std::string_view version,
                              std::span<const std::string_view> extensions) {
  std::string out;
  put_text(&out, 1, name);
  put_text(&out, 2, version);
  for (const auto extension : extensions) put_text(&out, 3, extension);
  return {{std::move(out), {}}};
}

Pieces encode_model_metadata(const ModelMetadata& model, std::string_view version) {
  std::string out;
  put_text(&out, 1, model.name);
  put_text(&out, 2, version);
  put_text(&out, 3, model.platform);
  for (const auto& input : model.inputs)
    put_bytes(&out, 4, encode_description(input.name, input.datatype, input.shape));
  for (const auto& output : model.outputs)
    put_bytes(&out, 5, encode_description(output.name, output.datatype, output.shape));
  return {{std::move(out), {}}};
}

Pieces encode_health(int status) {
  std::string out;
  put_number(&out, 1, static_cast<uint64_t>(status));
  return {{std::move(out), {}}};
}

Pieces encode_infer_response(const ModelRequest& model, std::string_view id,
                             std::span<const RequestTensor> outputs, const ServerTimes* times) {
  std::string head;
  put_text(&head, 1, model.name);
  put_text(&head, 2, model.version);
  put_text(&head, 3, id);
  if (times) {
    put_parameter(&head, "weir_received_ns", times->received_ns);
    put_parameter(&head, "weir_answered_ns", times->answered_ns);
    put_parameter(&head, "weir_queue_us", times->queue_us);
    put_parameter(&head, "weir_compute_us", times->compute_us);
  }
  for (const auto& output : outputs)
    put_bytes(&head, 5, encode_description(output.name, output.datatype, output.shape));
  Pieces out{{std::move(head), {}}};
  put_raw_contents(&out, 6, outputs);
  return out;
}

Pieces encode_index(std::span<const IndexedModel> models) {
  std::string out;
  for (const auto& model : models) {
    std::string entry;
    put_text(&entry, 1, model.model.name);
    put_text(&entry, 2, model.model.version);
    put_text(&entry, 3, model.ready ? "READY" : "UNAVAILABLE");
    put_text(&entry, 4, model.reason);
    put_bytes(&out, 1, entry);
  }
  return {{std::move(out), {}}};
}

Pieces encode_statistics(std::span<const ModelStatistics> models) {
  std::string out;
  for (const auto& model : models) put_bytes(&out, 1, encode_model_statistics(model));
  return {{std::move(out), {}}};
}

}  // namespace weir::net
