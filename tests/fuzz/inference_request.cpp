// Fuzz target: requests of clients of an inference server, in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_service_messages.hpp"
#include "net/server/reflection.hpp"
#include "net/server/served_model.hpp"
#include "peer_message.hpp"

namespace {

using namespace weir::net;
using weir::fuzz::expect;

void read_inputs(const Chunks& chunks, const InferRequest& request, size_t room) {
  expect(request.inputs.size() <= 256 && request.outputs.size() <= 256);
  std::vector<std::byte> to(room);
  for (const auto& input : request.inputs) {
    expect(input.shape.size() <= 16);
    expect(input.raw.has_value() == request.inputs.front().raw.has_value());
    if (input.raw) expect(input.raw->end <= chunks.size());
    if (const auto bytes = only_element(chunks, input, Sender::Client))
      expect(bytes->end <= chunks.size());
    if (const auto status = read_elements(chunks, input, to, Sender::Client); !status)
      expect(status.error().code == weir::Code::PEER_MESSAGE_INVALID);
  }
}

// A request that fits can be read whole, or has typed contents of another number.
void read_fitting(const Chunks& chunks, const InferRequest& request) {
  const ModelMetadata model{
      "m", "", {{"x", "FP32", {1, 2}}, {"y", "UINT8", {3}}}, {{"z", "FP32", {1}}}};
  const auto order = match_inputs(request, model);
  if (order) {
    expect(order->size() == 2);
    std::vector<std::byte> x(8), y(3);
    const auto read_x = read_elements(chunks, request.inputs[(*order)[0]], x, Sender::Client);
    const auto read_y = read_elements(chunks, request.inputs[(*order)[1]], y, Sender::Client);
    if (request.inputs.front().raw) expect(read_x && read_y);
  }
  const auto outputs = match_outputs(request, model);
  if (outputs) expect(outputs->size() == (request.outputs.empty() ? 1 : request.outputs.size()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto message = weir::fuzz::PeerMessage::read(data, size);
  if (!message) return 0;
  const Chunks& chunks = message->chunks;
  if (const auto request = parse_infer_request(chunks)) {
    read_inputs(chunks, *request, message->room);
    read_fitting(chunks, *request);
  }
  (void)parse_model_request(chunks);
  (void)parse_health_request(chunks);
  (void)parse_load_request(chunks);
  (void)parse_index_request(chunks);
  (void)Reflection::of_this_server().respond(chunks);
  return 0;
}
