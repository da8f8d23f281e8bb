// Fuzz target: answers of inference servers, in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "net/oip_messages.hpp"

namespace {

using namespace weir::net;

// Copies of the bytes, each in memory of its own, so that a read beyond one is found.
std::vector<std::vector<std::byte>> split(std::span<const std::byte> bytes, size_t size) {
  std::vector<std::vector<std::byte>> out;
  for (size_t at = 0; at < bytes.size(); at += size) {
    const auto part = bytes.subspan(at, std::min(size, bytes.size() - at));
    out.emplace_back(part.begin(), part.end());
  }
  return out;
}

void expect(bool condition) {
  if (!condition) std::abort();
}

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
  if (size < 2) return 0;
  const size_t chunk = data[0] % 32 + 1, room = data[1];
  const auto parts = split(std::as_bytes(std::span(data, size)).subspan(2), chunk);
  std::vector<Chunks::Chunk> pieces(parts.begin(), parts.end());
  const Chunks chunks(std::move(pieces));
  if (const auto response = parse_infer_response(chunks)) read_outputs(chunks, *response, room);
  if (const auto metadata = parse_model_metadata(chunks))
    expect(metadata->inputs.size() <= 256 && metadata->outputs.size() <= 256);
  (void)parse_model_ready(chunks);
  return 0;
}
