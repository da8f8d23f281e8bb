// Fuzz target: responses of inference servers, in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_contents.hpp"
#include "peer_message.hpp"

namespace {

using namespace weir::net;
using weir::fuzz::expect;

void read_outputs(const Chunks& chunks, const InferResponse& response, size_t room) {
  expect(response.outputs.size() <= 256);
  std::vector<std::byte> to(room);
  for (const auto& output : response.outputs) {
    expect(output.shape.size() <= 16);
    expect(output.raw.has_value() == response.outputs.front().raw.has_value());
    if (output.raw) expect(output.raw->end <= chunks.size());
    if (const auto status = read_elements(chunks, output, to, Sender::Server); !status)
      expect(status.error().code == weir::Code::PEER_MESSAGE_INVALID);
    const auto element = only_element(chunks, output, Sender::Server);
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
