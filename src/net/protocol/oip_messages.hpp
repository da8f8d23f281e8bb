// The messages of the Open Inference Protocol (package inference, proto3) that a client sends and
// receives.
//
// Requests are lists of pieces, so that tensors are sent from where they are; responses are read
// from the pieces of memory in which gRPC received them. A peer's message decides no allocation
// beyond the bytes that were received.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "net/protocol/wire.hpp"
#include "weir/result.hpp"

namespace weir::net {

inline constexpr std::string_view kService = "/inference.GRPCInferenceService/";

// A part of a request: its own bytes, or if there are none the caller's memory.
struct Piece {
  std::string own;
  std::span<const std::byte> borrowed;
};
using Pieces = std::vector<Piece>;

struct TensorText {
  std::string name, datatype;
  std::vector<int64_t> shape;  // -1 = any
};

struct ModelMetadata {
  std::string name, platform;
  std::vector<TensorText> inputs, outputs;
};

// A tensor of a request or a response.
struct InferTensor : TensorText {
  std::vector<Range> contents;  // of InferTensorContents
  std::optional<Range> raw;     // of its raw contents
};

// The parameter of a request that asks for the times of its response. A server that has it lists it
// among its extensions; others may refuse a parameter that they do not know.
inline constexpr std::string_view kTimesExtension = "weir_times";

// When a request came and was answered, by the server's wall clock, in nanoseconds since 1970; how
// long it waited for the pipeline, and how long it was in it. Sent as the parameters
// weir_received_ns, weir_answered_ns, weir_queue_us and weir_compute_us.
struct ServerTimes {
  int64_t received_ns = 0, answered_ns = 0, queue_us = 0, compute_us = 0;
};

struct InferResponse {
  std::optional<ServerTimes> times;  // if the server sent all of them, and they can be
  std::vector<InferTensor> outputs;
};

// One input of a request. `data` must outlive the request.
struct RequestTensor {
  std::string_view name, datatype;
  std::span<const int64_t> shape;
  std::span<const std::byte> data;  // dense, little-endian
};

// Raw: the bytes of the tensors, one field each. Typed: InferTensorContents, in which integers are
// written as varints, so they are copied.
enum class Contents { Raw, Typed };

// ModelMetadataRequest and ModelReadyRequest have the same fields.
Pieces encode_model_request(std::string_view model, std::string_view version);
// OPTION_VALUE for a type that has no typed contents (FP16). `copied` is increased by the bytes of
// tensors that were copied. `wants_times`: asks for the times of the response.
Result<Pieces> encode_infer_request(std::string_view model, std::string_view version,
                                    std::span<const RequestTensor> inputs, Contents contents,
                                    bool wants_times, uint64_t* copied);

// PEER_MESSAGE_INVALID for bytes that are not such a message, or are beyond limits: 256 tensors, 16
// dimensions, names of 1024 bytes.
Result<ModelMetadata> parse_model_metadata(const Chunks& chunks);
Result<bool> parse_model_ready(const Chunks& chunks);
// Reads from a ServerMetadataResponse whether the server has the extension.
Result<bool> parse_has_extension(const Chunks& chunks, std::string_view extension);
Result<InferResponse> parse_infer_response(const Chunks& chunks);

}  // namespace weir::net
