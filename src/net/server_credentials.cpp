// Makes credentials by gRPC's experimental API for files that change. Nothing else uses that API.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server_credentials.hpp"

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "net/server_security.hpp"

namespace weir::net {
namespace {

constexpr unsigned kLookAgainSeconds = 5;

using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free_all)>;

BioPtr bio_of(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free_all};
}

// gRPC would accept connections with files that do not fit, and end each of them.
Status check_pair(const ServerSecurity& security, const std::string& cert, const std::string& key) {
  const auto no_password = +[](char*, int, int, void*) { return 0; };
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(
      PEM_read_bio_X509(bio_of(cert).get(), nullptr, no_password, nullptr), X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> secret(
      PEM_read_bio_PrivateKey(bio_of(key).get(), nullptr, no_password, nullptr), EVP_PKEY_free);
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

}  // namespace

Result<std::shared_ptr<grpc::ServerCredentials>> server_credentials(
    const ServerSecurity& security) {
  if (security.cert.empty()) return grpc::InsecureServerCredentials();
  const auto cert = read_security_file(security.cert, "tls-cert");
  if (!cert) return cert.error();
  const auto key = read_security_file(security.key, "tls-key");
  if (!key) return key.error();
  if (auto status = check_pair(security, *cert, *key); !status) return status.error();
  if (!security.ca.empty())
    if (const auto ca = read_security_file(security.ca, "tls-ca"); !ca) return ca.error();
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

}  // namespace weir::net
