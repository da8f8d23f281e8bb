// The messages of the Open Inference Protocol, and of gRPC's health service, that a server receives
// and sends.
//
// A peer's message decides no allocation beyond the bytes that were received, and tensors are sent
// from where they are (oip_messages.hpp).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "net/protocol/oip_messages.hpp"

namespace weir::net {

// The fields of ModelReadyRequest, ModelMetadataRequest and ModelStatisticsRequest.
struct ModelRequest {
  std::string name, version;
};
// "resnet version 1"; "resnet" without a version.
std::string describe(const ModelRequest& model);
// Whether `served` is what `wanted` asks for: without a version, any of the name.
bool fits(const ModelRequest& wanted, const ModelRequest& served);

// The fields of RepositoryModelLoadRequest and RepositoryModelUnloadRequest.
struct LoadRequest {
  std::string model;
  bool has_parameters = false;  // a configuration, or the contents of files
};

struct InferRequest {
  std::string model, version, id;
  std::vector<InferTensor> inputs;
  std::vector<std::string> outputs;  // the names of the outputs to answer; none = all
  bool wants_times = false;          // the parameter weir_times is true
};

// PEER_MESSAGE_INVALID for bytes that are not such a message, or are beyond the limits of
// oip_messages.hpp.
Result<ModelRequest> parse_model_request(const Chunks& chunks);
Result<LoadRequest> parse_load_request(const Chunks& chunks);
// Whether a RepositoryIndexRequest asks for models that are ready alone.
Result<bool> parse_index_request(const Chunks& chunks);
Result<InferRequest> parse_infer_request(const Chunks& chunks);
// The service in a HealthCheckRequest.
Result<std::string> parse_health_request(const Chunks& chunks);

// ServerLiveResponse, ServerReadyResponse and ModelReadyResponse.
Pieces encode_flag(bool value);
Pieces encode_server_metadata(std::string_view name, std::string_view version,
                              std::span<const std::string_view> extensions);
Pieces encode_model_metadata(const ModelMetadata& model, std::string_view version);
// HealthCheckResponse: 1 = SERVING, 2 = NOT_SERVING, 3 = SERVICE_UNKNOWN.
Pieces encode_health(int status);

// Raw contents, which borrow the memory of the outputs. `times` may be null.
Pieces encode_infer_response(const ModelRequest& model, std::string_view id,
                             std::span<const RequestTensor> outputs, const ServerTimes* times);

// How often something happened, and how long it took in all.
struct Duration {
  uint64_t count = 0, ns = 0;
};
// What Triton's ModelStatistics reports of a model.
struct ModelStatistics {
  ModelRequest model;
  uint64_t last_inference_ms = 0;  // since 1970
  uint64_t inferences = 0, executions = 0;
  Duration success, fail, queue, compute_input, compute_infer, compute_output;
};
// An entry of RepositoryIndexResponse.
struct IndexedModel {
  ModelRequest model;
  bool ready = false;
  std::string reason;  // why it is not
};
Pieces encode_index(std::span<const IndexedModel> models);
Pieces encode_statistics(std::span<const ModelStatistics> models);

}  // namespace weir::net
