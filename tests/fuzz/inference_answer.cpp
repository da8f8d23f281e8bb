// Fuzz target: answers of inference servers, in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_messages.hpp"
#include "peer_message.hpp"

namespace {

using namespace weir::net;
using weir::fuzz::expect;

void read_outputs(const Chunks& chunks, const InferResponse& response, size_t room) {
  expect(response.outputs.size() <= 256);
  expect(response.raw.empty() || response.raw.size() == response.outputs.size());
  std::vector<std::byte> to(room);
  for (size_t i = 0; i < response.outputs.size(); ++i) {
    expect(response.outputs[i].shape.size() <= 16);
    if (!response.raw.empty()) expect(response.raw[i].end <= chunks.size());
    if (const auto status = read_output(chunks, response, i, to); !status)
      expect(status.error().code == weir::Code::PEER_MESSAGE_INVALID);
    const auto element = bytes_element(chunks, response, i);
    if (element) expect(element->begin <= element->end && element->end <= chunks.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto message = weir::fuzz::PeerMessage::read(data, size);
  if (!message) return 0;
  const Chunks& chunks = message->chunks;
  if (const auto response = parse_infer_response(chunks))
    read_outputs(chunks, *response, message->room);
  if (const auto metadata = parse_model_metadata(chunks))
    expect(metadata->inputs.size() <= 256 && metadata->outputs.size() <= 256);
  (void)parse_model_ready(chunks);
  return 0;
}
