// Encodes requests of the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_types.hpp"

namespace weir::net {
namespace {

constexpr uint32_t kParameters = 4, kInputs = 5, kRawContents = 7, kTensorContents = 5,
                   kBytesField = 8;

template <class Number>
void put_numbers(std::string* to, std::span<const std::byte> data) {
  for (size_t at = 0; at + sizeof(Number) <= data.size(); at += sizeof(Number)) {
    Number value;
    std::memcpy(&value, data.data() + at, sizeof value);
    put_varint(to, static_cast<uint64_t>(static_cast<int64_t>(value)));
  }
}

std::string packed_integers(uint32_t type, bool is_bool, std::span<const std::byte> data) {
  std::string out;
  switch (type) {
    case WEIR_INT8:
      put_numbers<int8_t>(&out, data);
      break;
    case WEIR_INT16:
      put_numbers<int16_t>(&out, data);
      break;
    case WEIR_INT32:
      put_numbers<int32_t>(&out, data);
      break;
    case WEIR_INT64:
      put_numbers<int64_t>(&out, data);
      break;
    case WEIR_UINT16:
      put_numbers<uint16_t>(&out, data);
      break;
    case WEIR_UINT32:
      put_numbers<uint32_t>(&out, data);
      break;
    case WEIR_UINT64:
      put_numbers<uint64_t>(&out, data);
      break;
    default:
      if (!is_bool) put_numbers<uint8_t>(&out, data);
      for (size_t i = 0; is_bool && i < data.size(); ++i)
        out.push_back(data[i] == std::byte{0} ? '\0' : '\1');
  }
  return out;
}

// Appends an input with its contents: floating-point numbers and BYTES from where they are.
void put_typed_tensor(Pieces* to, const RequestTensor& tensor, const OipType& type,
                      uint64_t* copied) {
  const bool in_place =
      type.type == WEIR_FLOAT32 || type.type == WEIR_FLOAT64 || type.content_field == kBytesField;
  std::string values;
  if (!in_place) {
    values = packed_integers(type.type, type.name == "BOOL", tensor.data);
    *copied += tensor.data.size();
  }
  const size_t bytes = in_place ? tensor.data.size() : values.size();
  std::string head;
  put_bytes_header(&head, type.content_field, bytes);
  std::string body = encode_description(tensor.name, tensor.datatype, tensor.shape);
  put_bytes_header(&body, kTensorContents, head.size() + bytes);
  body += head;
  std::string text;
  put_bytes_header(&text, kInputs, body.size() + bytes);
  text += body + values;
  to->push_back({std::move(text), {}});
  if (in_place) to->push_back({"", tensor.data});
}

}  // namespace

Pieces encode_model_request(std::string_view model, std::string_view version) {
  std::string out;
  put_bytes(&out, 1, model);
  put_text(&out, 2, version);
  return {{std::move(out), {}}};
}

Result<Pieces> encode_infer_request(std::string_view model, std::string_view version,
                                    std::span<const RequestTensor> inputs, Contents contents,
                                    bool wants_times, uint64_t* copied) {
  Pieces out = encode_model_request(model, version);
  if (wants_times) {
    std::string entry;
    put_bytes(&entry, 1, kTimesExtension);
    put_bytes(&entry, 2, "\x08\x01");  // bool_param: true
    put_bytes(&out.front().own, kParameters, entry);
  }
  for (const auto& tensor : inputs) {
    const auto* type = oip_type(tensor.datatype);
    if (contents == Contents::Raw) {
      put_bytes(&out.front().own, kInputs,
                encode_description(tensor.name, tensor.datatype, tensor.shape));
      continue;
    }
    if (!type || type->content_field == 0)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "a tensor cannot be sent as typed contents",
                   .offered = std::string(tensor.name) + " of type " + std::string(tensor.datatype),
                   .needed = "raw contents, because FP16 has no typed contents",
                   .fix = "custom=contents:raw"};
    put_typed_tensor(&out, tensor, *type, copied);
  }
  if (contents == Contents::Raw) put_raw_contents(&out, kRawContents, inputs);
  return out;
}

}  // namespace weir::net
