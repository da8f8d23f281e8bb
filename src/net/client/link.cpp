// Calls a server by gRPC's generic stub: request and response are bytes, without generated classes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/client/link.hpp"

#include <grpc/support/log.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>

#include "net/client/channel_arguments.hpp"
#include "net/protocol/grpc_bytes.hpp"
#include "net/protocol/token_file.hpp"

namespace weir::net {
namespace {

Status check_security(const ServerAddress& address, const Security& security) {
  if (!address.encrypted && !address.local && !security.insecure)
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "a connection to another machine would not be encrypted",
                 .offered = address.text,
                 .needed = "grpcs://, or custom=insecure:true on a network that you trust",
                 .fix = "model=grpcs" + address.text.substr(4)};
  const bool has_files = !security.ca.empty() || !security.cert.empty() || !security.key.empty();
  if (!address.encrypted && has_files)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "certificates have no effect on a connection without TLS",
                 .offered = address.text + " with ca, cert or key",
                 .needed = "grpcs://",
                 .fix = "model=grpcs" + address.text.substr(4)};
  if (security.cert.empty() != security.key.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a certificate and its key belong together",
                 .offered = security.cert.empty() ? "key without cert" : "cert without key",
                 .needed = "both",
                 .fix = "custom=cert:client.pem,key:client.key"};
  if (!security.token_file.empty() && !address.encrypted)
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "a token would be sent without TLS",
                 .offered = address.text + " with token-file",
                 .needed = "grpcs://",
                 .fix = "model=grpcs" + address.text.substr(4)};
  return ok();
}

Result<std::shared_ptr<grpc::ChannelCredentials>> make_credentials(const ServerAddress& address,
                                                                   const Security& security) {
  if (!address.encrypted) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions options;
  const struct {
    const std::string& path;
    const char* option;
    std::string* text;
  } files[] = {{security.ca, "ca", &options.pem_root_certs},
               {security.cert, "cert", &options.pem_cert_chain},
               {security.key, "key", &options.pem_private_key}};
  for (const auto& file : files) {
    if (file.path.empty()) continue;
    auto text = read_security_file(file.path, "option", file.option);
    if (!text) return text.error();
    *file.text = *std::move(text);
  }
  return grpc::SslCredentials(options);
}

// The first of the file; "" without a file.
Result<std::string> read_token(const Security& security) {
  if (security.token_file.empty()) return std::string();
  auto text = read_security_file(security.token_file, "option", "token-file");
  if (!text) return text.error();
  auto tokens = parse_tokens(*text, security.token_file, "option");
  if (!tokens.status) return tokens.status.error();
  return std::move(tokens.sendable.front());
}

Reply make_reply(const grpc::Status& status, const grpc::ByteBuffer& message) {
  Reply out;
  out.status = static_cast<int>(status.error_code());
  out.message = status.error_message();
  if (!status.ok()) return out;
  auto response = received(message);
  if (!response) {
    out.status = static_cast<int>(grpc::StatusCode::INTERNAL);
    out.message = "the answer cannot be read";
    return out;
  }
  out.chunks = std::move(response->chunks);
  out.memory = std::move(response->memory);
  return out;
}

class GrpcLink final : public Link {
 public:
  GrpcLink(std::shared_ptr<grpc::Channel> channel, std::string token)
      : stub_(std::move(channel)), token_(std::move(token)) {}

  Reply call(const std::string& method, const Pieces& request,
             const std::shared_ptr<const void>& memory, Clock::time_point deadline) override {
    return run(method, request, memory, deadline, false);
  }
  Reply call_when_connected(const std::string& method, const Pieces& request,
                            Clock::time_point deadline) override {
    return run(method, request, nullptr, deadline, true);
  }

 private:
  // The calling thread waits in gRPC and drives the connection, without a change of threads.
  Reply run(const std::string& method, const Pieces& request,
            const std::shared_ptr<const void>& memory, Clock::time_point deadline,
            bool waits_for_connection) {
    grpc::ClientContext context;
    context.set_wait_for_ready(waits_for_connection);
    const auto left = deadline - Clock::now();
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::duration_cast<std::chrono::system_clock::duration>(left));
    if (!token_.empty()) context.AddMetadata("authorization", "Bearer " + token_);
    grpc::CompletionQueue queue;
    const grpc::ByteBuffer message = make_message(request, memory);
    const auto rpc =
        stub_.PrepareUnaryCall(&context, std::string(kService) + method, message, &queue);
    rpc->StartCall();
    grpc::ByteBuffer response;
    grpc::Status status;
    rpc->Finish(&response, &status, this);
    void* tag = nullptr;
    bool done = false;
    queue.Next(&tag, &done);
    return make_reply(status, response);
  }

  grpc::GenericStub stub_;
  const std::string token_;
};

}  // namespace

Result<std::unique_ptr<Link>> Link::open(const ServerAddress& address, const Security& security,
                                         size_t max_bytes) {
  if (auto status = check_security(address, security); !status) return status.error();
  auto credentials = make_credentials(address, security);
  if (!credentials) return credentials.error();
  auto token = read_token(security);
  if (!token) return token.error();
  grpc::ChannelArguments arguments = channel_arguments(max_bytes);
  if (address.target.rfind("dns:", 0) == 0) arguments.SetLoadBalancingPolicyName("round_robin");
  auto channel = grpc::CreateCustomChannel(address.target, *credentials, arguments);
  return std::unique_ptr<Link>(new GrpcLink(std::move(channel), *std::move(token)));
}

std::string Link::library_version() {
  return grpc::Version();
}

void Link::set_log(void (*log)(bool error, const std::string& text)) {
  static std::atomic<void (*)(bool, const std::string&)> receiver;
  receiver = log;
  gpr_set_log_function([](gpr_log_func_args* line) {
    receiver.load()(line->severity == GPR_LOG_SEVERITY_ERROR,
                    std::string("gRPC: ") + line->message);
  });
}

}  // namespace weir::net
