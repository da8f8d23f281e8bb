// Engine oip: models on servers that speak the Open Inference Protocol over gRPC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_model.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct OipEngine {
  static constexpr const char *kName = "oip", *kAliases = "", *kExtensions = "",
                              *kLibrary = "An inference server";
  static constexpr uint64_t kFlags = WEIR_ENGINE_MODEL_IS_NO_FILE;
  static constexpr const char* kOptions = R"([
    {"name": "timeout-ms", "type": "integer", "default": "10000", "help": "milliseconds after which a request is late"},
    {"name": "in-flight", "type": "integer", "default": "4", "help": "requests in progress of one server"},
    {"name": "attempts", "type": "integer", "default": "2", "help": "attempts of one request, each on another server if there is one"},
    {"name": "idempotent", "type": "boolean", "default": "true", "help": "false: a request is sent at most once, after the answer to the previous one"},
    {"name": "probe-ms", "type": "integer", "default": "500", "help": "milliseconds between two probes of a server that failed"},
    {"name": "contents", "type": "values: auto|raw|typed", "default": "auto", "help": "how tensors are sent; auto: raw, and typed when the server refuses the first request"},
    {"name": "max-message", "type": "integer", "default": "64", "help": "maximum size of a message in MiB"},
    {"name": "insecure", "type": "boolean", "default": "false", "help": "allows connections to other machines without TLS"},
    {"name": "ca", "type": "file", "default": "", "help": "certificates (PEM) of the authorities that sign servers; default: those of the system"},
    {"name": "cert", "type": "file", "default": "", "help": "certificate (PEM) of this client"},
    {"name": "key", "type": "file", "default": "", "help": "private key (PEM) of this client"},
    {"name": "token-file", "type": "file", "default": "", "help": "file with a bearer token, sent over TLS only"},
    {"name": "input", "type": "text", "default": "", "help": "dimensions of the inputs, for servers without a description of the model"},
    {"name": "inputtype", "type": "text", "default": "", "help": "types of the inputs, for such servers"},
    {"name": "inputname", "type": "text", "default": "", "help": "names of the inputs, for such servers"},
    {"name": "output", "type": "text", "default": "", "help": "dimensions of the outputs, for such servers"},
    {"name": "outputtype", "type": "text", "default": "", "help": "types of the outputs, for such servers"},
    {"name": "outputname", "type": "text", "default": "", "help": "names of the outputs, for such servers"}])";
  using Model = OipModel;
  using Session = OipSession;

  static int probe(const std::string& path, std::span<const unsigned char>) {
    return path.rfind("grpc:", 0) == 0 || path.rfind("grpcs:", 0) == 0 ||
                   path.rfind("grpc+unix:", 0) == 0
               ? 100
               : 0;
  }
  static Result<LibraryFacts> library() {
    return LibraryFacts{"libgrpc++", net::Link::library_version()};
  }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::OipEngine)
