// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/listener.hpp"

#include <grpcpp/resource_quota.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>

#include "net/server/grpc_connections.hpp"
#include "net/server/keepalive.hpp"
#include "net/server/server_call.hpp"
#include "net/server/server_security.hpp"

namespace weir::net {
namespace {

using SystemClock = std::chrono::system_clock;
constexpr int kMaxMetadataBytes = 16 << 10, kHandshakeMs = 2000, kUnreadBytes = 64 << 10;
constexpr int kMinPingMs = 100;  // of clients that watch this server (weir_keepalive)
constexpr std::chrono::milliseconds kEndOfCalls{500};
constexpr unsigned kLookAgainSeconds = 5;  // for certificates that changed

class Service final : public grpc::CallbackGenericService {
 public:
  explicit Service(ServerRules* rules) : rules_(rules) {}
  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    return new ServerReactor(context, rules_);
  }

 private:
  ServerRules* const rules_;
};

// Limits the memory of all addresses together, as far as they are limited.
void set_quota(grpc::ServerBuilder* builder, const ListenOptions& options) {
  const uint64_t connections = options.max_connections, each = options.max_address_connections;
  if (connections == 0 || options.max_address_bytes == 0) return;
  const uint64_t addresses = each == 0 ? connections : (connections + each - 1) / each;
  grpc::ResourceQuota quota("weir");
  quota.Resize(addresses * std::max<uint64_t>(options.max_address_bytes, options.max_bytes));
  builder->SetResourceQuota(quota);
}

void set_limits(grpc::ServerBuilder* builder, const ListenOptions& options) {
  const int max = static_cast<int>(std::min<size_t>(options.max_bytes, INT32_MAX));
  builder->SetMaxReceiveMessageSize(max);
  builder->SetMaxSendMessageSize(max);
  // A compressed message could be far larger than what was received.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder->AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, kMaxMetadataBytes);
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS,
                              static_cast<int>(std::min<uint32_t>(options.idle_ms, INT32_MAX)));
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kMinPingMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // What a client may send before its message is read. gRPC's probing would let it grow.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kUnreadBytes);
  set_keepalive(builder);
  set_quota(builder, options);
  if (const uint32_t streams = max_streams(options); streams != 0)
    builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, static_cast<int>(streams));
}

using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free_all)>;

BioPtr make_bio(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free_all};
}

// gRPC would accept connections with files that do not fit, and end each of them.
Status check_pair(const ServerSecurity& security, const std::string& cert, const std::string& key) {
  const auto no_password = +[](char*, int, int, void*) { return 0; };
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(make_bio(cert).get(), nullptr, no_password, nullptr), X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> secret(
      PEM_read_bio_PrivateKey(make_bio(key).get(), nullptr, no_password, nullptr), EVP_PKEY_free);
  if (certificate && secret && X509_check_private_key(certificate.get(), secret.get()) == 1)
    return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = !certificate ? "the file of the property tls-cert has no certificate"
              : !secret ? "the file of the property tls-key has no key, or the key has a password"
                        : "the certificate and the key do not belong together",
      .offered = "tls-cert=" + security.cert + " tls-key=" + security.key,
      .needed = "a certificate and its key, in PEM",
      .fix = "weir pki issue NAME, which creates both"};
}

// Makes the credentials of a server, plain without a certificate. FILE_NOT_FOUND; OPTION_VALUE for
// a certificate and a key that cannot be read or do not belong together.
Result<std::shared_ptr<grpc::ServerCredentials>> server_credentials(
    const ServerSecurity& security) {
  if (security.cert.empty()) return grpc::InsecureServerCredentials();
  const auto cert = read_security_file(security.cert, "property", "tls-cert");
  if (!cert) return cert.error();
  const auto key = read_security_file(security.key, "property", "tls-key");
  if (!key) return key.error();
  if (auto status = check_pair(security, *cert, *key); !status) return status.error();
  if (!security.ca.empty())
    if (const auto ca = read_security_file(security.ca, "property", "tls-ca"); !ca)
      return ca.error();
  // gRPC's experimental API, for files that change.
  grpc::experimental::TlsServerCredentialsOptions options(
      std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
          security.key, security.cert, security.ca, kLookAgainSeconds));
  options.watch_identity_key_cert_pairs();
  if (!security.ca.empty()) options.watch_root_certs();
  options.set_cert_request_type(security.ca.empty()
                                    ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                                    : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  return grpc::experimental::TlsServerCredentials(options);
}

class GrpcListener final : public Listener {
 public:
  GrpcListener(const ListenOptions& options, std::unique_ptr<TokenFile> tokens, Handler handler)
      : rules_(options, std::move(tokens), std::move(handler)), service_(&rules_) {}
  GrpcListener(const GrpcListener&) = delete;
  GrpcListener& operator=(const GrpcListener&) = delete;
  ~GrpcListener() override {
    if (rules_.connections) rules_.connections->stop();
    if (server_) server_->Shutdown(SystemClock::now() + kEndOfCalls);
  }

  Status start(const ListenOptions& options) {
    auto credentials = server_credentials(options.security);
    if (!credentials) return credentials.error();
    grpc::ServerBuilder builder;
    set_limits(&builder, options);
    builder.RegisterCallbackGenericService(&service_);
    auto connections = ConnectionAcceptor::listen(options);
    if (!connections) return connections.error();
    rules_.connections = *std::move(connections);
    auto server =
        serve_connections(&builder, *credentials, rules_.connections.get(), address_text(options));
    if (!server) return server.error();
    server_ = *std::move(server);
    return ok();
  }
  uint32_t port() const noexcept override { return rules_.connections->port(); }
  uint64_t refused() const noexcept override {
    return rules_.not_allowed + rules_.admission.refused() + rules_.connections->refused();
  }

 private:
  ServerRules rules_;
  Service service_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace

bool is_stream_method(std::string_view method) {
  return method == "/grpc.health.v1.Health/Watch" || method.starts_with("/grpc.reflection.");
}

Result<std::unique_ptr<Listener>> Listener::open(const ListenOptions& options, Handler handler) {
  if (auto status = check_security(options); !status) return status.error();
  std::unique_ptr<TokenFile> tokens;
  if (!options.security.token_file.empty()) {
    auto opened = TokenFile::open(options.security.token_file);
    if (!opened) return opened.error();
    tokens = *std::move(opened);
  }
  auto out = std::make_unique<GrpcListener>(options, std::move(tokens), std::move(handler));
  if (auto status = out->start(options); !status) return status.error();
  return std::unique_ptr<Listener>(std::move(out));
}

}  // namespace weir::net
