// Fuzz target: requests of clients of an inference server, in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "net/oip_service_messages.hpp"
#include "net/request_check.hpp"

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

void read_inputs(const Chunks& chunks, const InferRequest& request, size_t room) {
  expect(request.inputs.size() <= 256 && request.outputs.size() <= 256);
  expect(request.raw.empty() || request.raw.size() == request.inputs.size());
  std::vector<std::byte> to(room);
  for (size_t i = 0; i < request.inputs.size(); ++i) {
    expect(request.inputs[i].shape.size() <= 16);
    if (!request.raw.empty()) expect(request.raw[i].end <= chunks.size());
    if (const auto status = read_input(chunks, request, i, to); !status)
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
    const auto read_x = read_input(chunks, request, (*order)[0], x);
    const auto read_y = read_input(chunks, request, (*order)[1], y);
    if (!request.raw.empty()) expect(read_x && read_y);
  }
  const auto outputs = match_outputs(request, model);
  if (outputs) expect(outputs->size() == (request.outputs.empty() ? 1 : request.outputs.size()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  const size_t chunk = data[0] % 32 + 1, room = data[1];
  const auto parts = split(std::as_bytes(std::span(data, size)).subspan(2), chunk);
  std::vector<Chunks::Chunk> pieces(parts.begin(), parts.end());
  const Chunks chunks(std::move(pieces));
  if (const auto request = parse_infer_request(chunks)) {
    read_inputs(chunks, *request, room);
    read_fitting(chunks, *request);
  }
  (void)parse_model_request(chunks);
  (void)parse_health_request(chunks);
  return 0;
}
