// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/tls_handshake.hpp"

#include <gio/gio.h>
#include <glib-unix.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <memory>
#include <string_view>

namespace weir::transport {
namespace {

struct Reason {
  std::string what, fix;
};

// Returns why this client rejects the certificate.
Reason rejected_certificate(long result, const BrokerOptions& options) {
  switch (result) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return {"its certificate has expired",
              "issue a new certificate for the broker, and compare the clocks of both machines"};
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return {"its certificate is not valid yet", "set the clocks of both machines"};
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return {"its certificate is not for " + options.host,
              "connect by a name that the certificate has, or issue one for this name: "
              "weir pki issue " +
                  options.host};
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return {"its certificate was not signed by the authority in " + options.tls.ca,
              "set tls-ca to the file of the authority that signed the broker's certificate"};
    default:
      return {std::string("its certificate is rejected: ") + X509_verify_cert_error_string(result),
              "issue a new certificate for the broker"};
  }
}

// Returns why the broker rejects the certificate of this client, or that it has none.
Reason rejected_client(const BrokerOptions& options) {
  return {options.tls.cert.empty()
              ? "it ended the connection; it probably needs a certificate of the client"
              : "it does not accept the certificate " + options.tls.cert,
          "set tls-cert and tls-key to a certificate of an authority that the broker trusts"};
}

// Returns the reason in what OpenSSL reports: alerts of the broker, and records that are not TLS.
Reason broken_handshake(const std::string& error, const BrokerOptions& options) {
  const auto has = [&error](const char* text) { return error.find(text) != error.npos; };
  if (!options.tls.psk.empty())
    return {"it does not accept the pre-shared key: " + error,
            "compare psk and psk-identity with the broker's file of keys"};
  if (has("wrong version number") || has("unexpected eof"))
    return {"there is no TLS at this port: " + error,
            "set the port at which the broker has TLS, usually 8883"};
  if (has("alert")) return rejected_client(options);
  return {"the TLS handshake failed: " + error,
          "compare the versions and ciphers of TLS that the broker allows"};
}

template <auto free>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free(object);
  }
};
using Context = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;
using Connection = std::unique_ptr<SSL, Free<SSL_free>>;
template <class T>
using Object = std::unique_ptr<T, Free<g_object_unref>>;

constexpr int kSeconds = 2;  // for the connection, and for each response

Context make_context(const BrokerTls& tls) {
  Context out(SSL_CTX_new(TLS_client_method()));
  if (!out) return out;
  if (tls.ca.empty())
    SSL_CTX_set_default_verify_paths(out.get());
  else
    SSL_CTX_load_verify_locations(out.get(), tls.ca.c_str(), nullptr);
  SSL_CTX_set_verify(out.get(), SSL_VERIFY_PEER, nullptr);
  if (!tls.cert.empty()) {
    SSL_CTX_use_certificate_chain_file(out.get(), tls.cert.c_str());
    SSL_CTX_use_PrivateKey_file(out.get(), tls.key.c_str(), SSL_FILETYPE_PEM);
  }
  return out;
}

void set_name(SSL* ssl, const std::string& host) {
  if (g_hostname_is_ip_address(host.c_str())) {
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl), host.c_str());
    return;
  }
  SSL_set1_host(ssl, host.c_str());
  SSL_set_tlsext_host_name(ssl, host.c_str());
}

struct Handshake {
  long verified = X509_V_OK;
  bool is_rejected = false;  // by the broker, after it
};

Handshake shake_hands(const BrokerOptions& options) {
  const Context context = make_context(options.tls);
  const Object<GSocketClient> client(g_socket_client_new());
  g_socket_client_set_enable_proxy(client.get(), FALSE);  // libmosquitto uses none
  g_socket_client_set_timeout(client.get(), kSeconds);
  const Object<GSocketConnection> connection(g_socket_client_connect_to_host(
      client.get(), options.host.c_str(), options.port, nullptr, nullptr));
  if (!context || !connection) return {};
  GSocket* const socket = g_socket_connection_get_socket(connection.get());
  const int descriptor = g_socket_get_fd(socket);
  g_unix_set_fd_nonblocking(descriptor, FALSE, nullptr);
  const timeval limit{kSeconds, 0};
  setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  const Connection ssl(SSL_new(context.get()));
  if (!ssl || SSL_set_fd(ssl.get(), descriptor) != 1) return {};
  set_name(ssl.get(), options.host);
  Handshake out;
  const bool is_done = SSL_connect(ssl.get()) == 1;
  out.verified = SSL_get_verify_result(ssl.get());
  char byte = 0;
  // With TLS 1.3 a broker rejects a certificate, or that there is none, after the handshake.
  const int got = is_done ? SSL_read(ssl.get(), &byte, 1) : 0;
  out.is_rejected = is_done && got <= 0 && SSL_get_error(ssl.get(), got) != SSL_ERROR_WANT_READ;
  ERR_clear_error();
  return out;
}

}  // namespace

bool has_unread_tls_data(mosquitto* client) {
  const auto* const ssl = static_cast<const SSL*>(mosquitto_ssl_get(client));
  return ssl && SSL_pending(ssl) > 0;
}

std::string tls_error_of_log(const char* line) {
  // "OpenSSL Error[0]: error:0A000086:SSL routines::certificate verify failed"
  const std::string_view text = line;
  if (!text.starts_with("OpenSSL Error")) return "";
  return std::string(text.substr(text.rfind(':') + 1));
}

std::optional<Error> find_tls_failure(const BrokerOptions& options, const std::string& error) {
  if (!options.tls.is_enabled()) return std::nullopt;
  const Handshake handshake = options.tls.psk.empty() ? shake_hands(options) : Handshake{};
  const bool is_rejected = handshake.verified != X509_V_OK;
  if (!is_rejected && !handshake.is_rejected && error.empty()) return std::nullopt;
  auto reason = is_rejected             ? rejected_certificate(handshake.verified, options)
                : handshake.is_rejected ? rejected_client(options)
                                        : broken_handshake(error, options);
  return Error{.code = Code::BROKER_REFUSED,
               .what = "the MQTT broker " + options.host + ":" + std::to_string(options.port) +
                       " is not trusted, or does not trust this client",
               .offered = std::move(reason.what),
               .needed = "certificates or keys that both sides accept",
               .fix = std::move(reason.fix)};
}

}  // namespace weir::transport
