// Sends frames to servers and takes their responses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <optional>

#include "net/client/link.hpp"
#include "net/protocol/oip_contents.hpp"
#include "oip/oip_model.hpp"
#include "oip/oip_signature.hpp"
#include "tensor_check.hpp"
#include "weir/abi.h"
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

// Every element has taken at least one byte of the response.
size_t received_bytes(const net::InferTensor& output) {
  if (output.raw) return output.raw->size();
  size_t out = 0;
  for (const auto range : output.contents) out += range.size();
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
    const auto element = net::only_element(reply.chunks, given, net::Sender::Server);
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
  if (out.bytes / element_bytes(out.info.type) > received_bytes(given))
    return other_output(describe_output(given) + " with fewer elements", wanted.to_string());
  if (to.data && to.bytes != out.bytes)
    return other_output(describe_output(given), std::to_string(to.bytes) + " bytes");
  return out;
}

// Copies the outputs into the memory of `frame`, or into memory of the host where it has none, and
// increases `copied` by their bytes. `times`: those of the response, if it has any.
// PEER_MESSAGE_INVALID for outputs other than the expected ones.
Status take_outputs(const net::Reply& reply, const std::vector<OipTensor>& expected,
                    const weir_frame& frame, uint64_t* copied,
                    std::optional<net::ServerTimes>* times) {
  const auto response = net::parse_infer_response(reply.chunks);
  if (!response) return response.error();
  *times = response->times;
  const auto tensors = get_tensors(frame);
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
      auto status = net::read_elements(reply.chunks, response->outputs[taken[i].index], to,
                                       net::Sender::Server);
      if (!status) return status;
    }
    *copied += taken[i].bytes;
  }
  return ok();
}

using net::Outcome;
using Bytes = std::span<const std::byte>;

// The memory of the inputs, kept until gRPC has sent it: also after the request has ended, when a
// server reads slowly.
struct HeldInputs {
  std::vector<Bytes> tensors;
  std::shared_ptr<const void> memory;
  uint64_t copied = 0;
};

// Empty if the host cannot keep the memory: batches, tensors that are copies.
std::shared_ptr<const void> hold(const weir_frame& in) {
  const auto* holder =
      static_cast<const weir_frame_holder*>(module_host->extension(WEIR_HOLD_FRAME));
  void (*release)(void*) = nullptr;
  void* owner = nullptr;
  if (!holder || holder->hold(&in, &release, &owner) != WEIR_OK) return nullptr;
  return {owner, [release](void* held) { release(held); }};
}

HeldInputs hold_inputs(const weir_frame& in) {
  HeldInputs out;
  for (const auto& tensor : get_tensors(in))
    out.tensors.push_back({static_cast<const std::byte*>(tensor.data), tensor.bytes});
  out.memory = hold(in);
  if (out.memory) return out;
  auto copies = std::make_shared<std::vector<std::vector<std::byte>>>();
  for (auto& tensor : out.tensors) {
    const auto& copy = copies->emplace_back(tensor.begin(), tensor.end());
    out.copied += copy.size();
    tensor = copy;
  }
  out.memory = std::move(copies);
  return out;
}

net::Link::Clock::time_point get_expiry(const weir_frame& in) {
  using Clock = net::Link::Clock;
  const bool has = in.struct_size >= offsetof(weir_frame, expires) + sizeof in.expires;
  if (!has || in.expires <= 0) return Clock::time_point::max();
  return Clock::time_point(std::chrono::nanoseconds(in.expires));
}

// What invoke returns.
int to_result(Outcome outcome) {
  switch (outcome) {
    case Outcome::Answered:
      return WEIR_OK;
    case Outcome::Late:
      return WEIR_RESULT_LATE;
    case Outcome::Refused:
      return WEIR_RESULT_REFUSED;
    default:
      return WEIR_RESULT_LOST;
  }
}

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::Answered:
      return "answered";
    case Outcome::Late:
      return "late";
    case Outcome::Refused:
      return "refused";
    default:
      return "lost";
  }
}

// Several threads may invoke one session.
struct LastAnswer {
  uint64_t session = 0;
  const char* server = nullptr;
};
thread_local LastAnswer last_answer;
std::atomic<uint64_t> next_session{1};

}  // namespace

net::ServerSet::Ended OipModel::send(const weir_frame& in, const weir_frame& out,
                                     net::Contents contents) const {
  const auto held = hold_inputs(in);
  uint64_t copied = held.copied, received = 0;
  const auto tensors = get_tensors(in);
  const std::vector<int64_t> ones(WEIR_RANK_LIMIT, 1);
  std::vector<net::RequestTensor> inputs;
  for (size_t i = 0; i < tensors.size(); ++i) {
    const auto& expected = signature_.inputs[i];
    const auto shape = expected.is_bytes()
                           ? std::span(ones).first(expected.bytes_rank)
                           : std::span<const int64_t>(tensors[i].info.shape, tensors[i].info.rank);
    inputs.push_back({expected.name, expected.datatype, shape, held.tensors[i]});
  }
  auto ended = servers_->request(
      [&](size_t server) {
        const auto& address = servers_->address(server);
        return net::encode_infer_request(address.model, address.version, inputs, contents,
                                         has_times_[server], &copied);
      },
      held.memory, get_expiry(in),
      [&](const auto& arrived, auto* times) {
        return take_outputs(arrived.reply, signature_.outputs, out, &received, times);
      });
  copied_out_ += copied;
  copied_in_ += received;
  return ended;
}

net::Outcome OipModel::request(const weir_frame& in, const weir_frame& out, size_t* server) const {
  const auto contents = contents_.load();
  auto ended = send(in, out, contents);
  const bool other_contents =
      ended.outcome == Outcome::Refused && !options_.contents && !answered_ &&
      contents == net::Contents::Raw &&
      ended.reply.status == static_cast<int>(net::CallStatus::InvalidArgument);
  if (other_contents) {
    ended = send(in, out, net::Contents::Typed);
    if (ended.outcome == Outcome::Answered) contents_ = net::Contents::Typed;
  }
  if (ended.outcome == Outcome::Answered) answered_ = true;
  report(ended);
  *server = ended.server;
  return ended.outcome;
}

// A warning when requests begin to end in another way, not for each of them.
void OipModel::report(const net::ServerSet::Ended& ended) const {
  const int outcome = static_cast<int>(ended.outcome);
  if (reported_.exchange(outcome) == outcome) return;
  if (ended.outcome == Outcome::Answered) {
    log(WEIR_LOG_INFO, "requests are answered again by " + servers_->address(ended.server).text);
    return;
  }
  const std::string server =
      ended.tried ? servers_->address(ended.server).text : "no server that could be tried";
  log(WEIR_LOG_WARNING, std::string("a request is ") + to_string(ended.outcome) + ": " + server +
                            (ended.reply.message.empty() ? "" : ": " + ended.reply.message));
}

OipSession::OipSession(const OipModel& model) : model_(model), number_(next_session++) {}

Status OipSession::resolve(std::span<const weir_tensor_info> in,
                           std::span<weir_tensor_info> out) const {
  if (auto status = check_infos(model_.inputs(), in, "input"); !status) return status;
  if (auto status = check_count(model_.outputs(), out.size(), "output"); !status) return status;
  std::copy(model_.outputs().begin(), model_.outputs().end(), out.begin());
  for (auto& output : out)
    for (size_t i = 0; i < in.size(); ++i)
      if (output.batch_axis == 0 && output.shape[0] == -1) output.shape[0] = in[i].shape[0];
  return ok();
}

int OipSession::invoke(const weir_frame& in, weir_frame& out) {
  if (auto status = check_inputs(model_.inputs(), get_tensors(in)); !status)
    throw Failure(status.error());
  size_t server = 0;
  last_answer = {};
  const auto outcome = model_.request(in, out, &server);
  if (outcome == Outcome::Answered) last_answer = {number_, model_.get_address(server)};
  return to_result(outcome);
}

const char* OipSession::answered_by() const {
  return last_answer.session == number_ ? last_answer.server : nullptr;
}

}  // namespace weir::engine
