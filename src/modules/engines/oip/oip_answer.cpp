// Checks the outputs of an answer before anything is allocated for them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_answer.hpp"

#include <algorithm>
#include <optional>

#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

std::string describe_output(const net::TensorText& output) {
  return OipTensor{.name = output.name, .datatype = output.datatype, .shape = output.shape}
      .to_string();
}

Error other_output(std::string offered, std::string needed) {
  return {.code = Code::PEER_MESSAGE_INVALID,
          .what = "the answer of a server has different outputs than the model",
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = "start the pipeline again if another model was loaded on the server"};
}

bool fits(const std::vector<int64_t>& shape, const std::vector<int64_t>& expected) {
  return std::equal(shape.begin(), shape.end(), expected.begin(), expected.end(),
                    [](int64_t a, int64_t b) { return a >= 0 && (b < 0 || a == b); });
}

// Servers may send outputs in any order; models without a description have no names.
std::optional<size_t> find(const net::InferResponse& response, const OipTensor& wanted, size_t at) {
  if (wanted.name.empty()) return at < response.outputs.size() ? std::optional(at) : std::nullopt;
  for (size_t i = 0; i < response.outputs.size(); ++i)
    if (response.outputs[i].name == wanted.name) return i;
  return std::nullopt;
}

struct Taken {
  size_t index;  // in the response
  weir_tensor_info info;
  uint64_t bytes;
  net::Range element;  // of BYTES
};

// Every element has taken at least one byte of the answer.
size_t received_bytes(const net::InferResponse& response, size_t index) {
  if (!response.raw.empty()) return response.raw[index].size();
  size_t out = 0;
  for (const auto range : response.outputs[index].contents) out += range.size();
  return out;
}

Result<Taken> check(const net::Reply& reply, const net::InferResponse& response,
                    const OipTensor& wanted, size_t at, const weir_tensor& to) {
  const auto index = find(response, wanted, at);
  if (!index) return other_output("no such output", wanted.to_string());
  const auto& given = response.outputs[*index];
  if (given.datatype != wanted.datatype)
    return other_output(describe_output(given), wanted.to_string());
  Taken out{*index, wanted.info(), 0, {}};
  if (wanted.is_bytes()) {
    const auto element = net::bytes_element(reply.chunks, response, *index);
    if (!element) return element.error();
    out.element = *element;
    out.info.shape[0] = static_cast<int64_t>(element->size());
  } else {
    if (!fits(given.shape, wanted.shape))
      return other_output(describe_output(given), wanted.to_string());
    set_shape(&out.info, given.shape.begin(), given.shape.size());
  }
  const auto bytes = tensor_bytes(out.info);
  if (!bytes) return other_output(describe_output(given), "a size that fits into memory");
  out.bytes = *bytes;
  if (out.bytes / element_bytes(out.info.type) > received_bytes(response, *index))
    return other_output(describe_output(given) + " with fewer elements", wanted.to_string());
  if (to.data && to.bytes != out.bytes)
    return other_output(describe_output(given), std::to_string(to.bytes) + " bytes");
  return out;
}

}  // namespace

Status take_outputs(const net::Reply& reply, const std::vector<OipTensor>& expected,
                    const weir_frame& frame, uint64_t* copied,
                    std::optional<net::AnswerTimes>* times) {
  const auto response = net::parse_infer_response(reply.chunks);
  if (!response) return response.error();
  *times = response->times;
  const auto tensors = tensors_of(frame);
  if (tensors.size() != expected.size())
    return Error{.code = Code::INTERNAL, .what = "a frame has a different number of outputs"};
  std::vector<Taken> taken;
  for (size_t i = 0; i < expected.size(); ++i) {
    auto one = check(reply, *response, expected[i], i, tensors[i]);
    if (!one) return one.error();
    taken.push_back(*one);
  }
  for (size_t i = 0; i < taken.size(); ++i) {
    if (!tensors[i].data) weir::allocate(&tensors[i], taken[i].info, taken[i].bytes);
    tensors[i].info = taken[i].info;
    if (expected[i].is_bytes()) {
      reply.chunks.copy(taken[i].element, tensors[i].data);
    } else {
      const std::span to(static_cast<std::byte*>(tensors[i].data), taken[i].bytes);
      auto status = net::read_output(reply.chunks, *response, taken[i].index, to);
      if (!status) return status;
    }
    *copied += taken[i].bytes;
  }
  return ok();
}

}  // namespace weir::engine
