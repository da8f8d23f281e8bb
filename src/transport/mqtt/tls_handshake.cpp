// Reads the result of OpenSSL's verification, and the alerts that a broker sends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/tls_handshake.hpp"

#include <string_view>

#include "transport/mqtt/mosquitto_handle.hpp"

namespace weir::transport {
namespace {

struct Reason {
  std::string what, fix;
};

// Of a certificate that this client rejects.
Reason rejected_certificate(long result, const BrokerOptions& options) {
  switch (result) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return {"its certificate has expired",
              "issue a new certificate for the broker, and compare the clocks of both machines"};
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return {"its certificate is not valid yet", "set the clocks of both machines"};
    case X509_V_ERR_UNSPECIFIED:  // what libmosquitto's own check leaves behind
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
      return {"its certificate is not of the authority in " + options.tls.ca,
              "set tls-ca to the file of the authority that signed the broker's certificate"};
    default:
      return {std::string("its certificate is rejected: ") + X509_verify_cert_error_string(result),
              "issue a new certificate for the broker"};
  }
}

// Of the certificate of this client, or of none.
Reason rejected_client(const BrokerOptions& options) {
  return {options.tls.cert.empty() ? "it ended the connection, as if it needs a "
                                     "certificate of the client"
                                   : "it does not accept the certificate " + options.tls.cert,
          "set tls-cert and tls-key to a certificate of an authority that the broker trusts"};
}

// Of what OpenSSL reports: alerts of the broker, and records that are not TLS.
Reason broken_handshake(const std::string& error, const BrokerOptions& options) {
  const auto has = [&error](const char* text) { return error.find(text) != error.npos; };
  if (!options.tls.psk.empty())
    return {"it does not accept the pre-shared key: " + error,
            "compare psk and psk-identity with the broker's file of keys"};
  if (has("wrong version number") || has("unexpected eof"))
    return {"there is no TLS at this port: " + error,
            "set the port at which the broker has TLS, often 8883"};
  if (has("alert")) return rejected_client(options);
  return {"the TLS handshake failed: " + error,
          "compare the versions and ciphers of TLS that the broker allows"};
}

}  // namespace

TlsHandshake::TlsHandshake(mosquitto* client) : client_(client) {}

TlsHandshake::~TlsHandshake() {
  // The library formats a line for each packet while there is a callback.
  mosquitto_log_callback_set(client_, nullptr);
}

void TlsHandshake::begin() {
  auto* const ssl = static_cast<SSL*>(mosquitto_ssl_get(client_));
  if (ssl && SSL_up_ref(ssl) == 1) ssl_.reset(ssl);
}

void TlsHandshake::log(const char* line) {
  // "OpenSSL Error[0]: error:0A000086:SSL routines::certificate verify failed"
  const std::string_view text = line;
  if (!error_.empty() || !text.starts_with("OpenSSL Error")) return;
  error_ = text.substr(text.rfind(':') + 1);
}

std::optional<Error> TlsHandshake::failure(const BrokerOptions& options) const {
  if (!options.tls.is_enabled()) return std::nullopt;
  const long verified = ssl_ ? SSL_get_verify_result(ssl_.get()) : X509_V_OK;
  // With TLS 1.3 a broker rejects the certificate of a client, or that there is none, after the
  // handshake: by an alert that is lost when the broker closes the connection.
  const bool is_rejected = ssl_ && SSL_is_init_finished(ssl_.get());
  if (verified == X509_V_OK && error_.empty() && !is_rejected) return std::nullopt;
  auto reason = verified != X509_V_OK ? rejected_certificate(verified, options)
                : is_rejected         ? rejected_client(options)
                                      : broken_handshake(error_, options);
  return Error{.code = Code::SERVER_REFUSED,
               .what = "the MQTT broker " + options.host + ":" + std::to_string(options.port) +
                       " is not trusted, or does not trust this client",
               .offered = std::move(reason.what),
               .needed = "certificates or keys that both sides accept",
               .fix = std::move(reason.fix)};
}

}  // namespace weir::transport
