// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pki/certificates.hpp"

#include <arpa/inet.h>
#include <openssl/bn.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <array>
#include <ctime>
#include <memory>
#include <utility>

namespace weir::app {
namespace {

template <auto Free>
struct Deleter {
  void operator()(auto* pointer) const { Free(pointer); }
};
template <class T, auto Free>
using Unique = std::unique_ptr<T, Deleter<Free>>;
using Key = Unique<EVP_PKEY, EVP_PKEY_free>;
using X509Certificate = Unique<X509, X509_free>;
using Memory = Unique<BIO, BIO_free_all>;

constexpr int kSerialBits = 159;      // RFC 5280: positive, 20 octets at most
constexpr long kClockSkew = 5L * 60;  // seconds by which the clock of a peer may be late
constexpr long kSecondsOfDay = 86400L, kSecondsToRetry = 60L;

using Extensions = std::vector<std::pair<int, std::string>>;  // NID and OpenSSL's text of it

Error crypto_error(const std::string& what) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_get_error(), reason.data(), reason.size());
  ERR_clear_error();
  return Error{.code = Code::INTERNAL, .what = what, .offered = reason.data()};
}

Error authority_error(const std::string& what) {
  ERR_clear_error();
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = what,
               .offered = "ca.pem and ca.key",
               .needed = "both files as weir pki init wrote them",
               .fix = "weir pki init NEW-FOLDER"};
}

template <class Write>
std::string pem(Write write) {
  const Memory out(BIO_new(BIO_s_mem()));
  if (!out || write(out.get()) != 1) return "";
  char* data = nullptr;
  const long size = BIO_get_mem_data(out.get(), &data);
  return {data, static_cast<size_t>(size)};
}

Memory reader(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

bool set_serial(X509* certificate) {
  const Unique<BIGNUM, BN_free> number(BN_new());
  return number && BN_rand(number.get(), kSerialBits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

bool set_subject(X509* certificate, const std::string& name) {
  const auto* text = reinterpret_cast<const unsigned char*>(name.data());
  return X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8, text,
                                    static_cast<int>(name.size()), -1, 0) == 1;
}

bool add_extensions(X509* certificate, X509* issuer, const Extensions& extensions) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  for (const auto& [nid, text] : extensions) {
    const Unique<X509_EXTENSION, X509_EXTENSION_free> extension(
        X509V3_EXT_conf_nid(nullptr, &context, nid, text.c_str()));
    if (!extension || X509_add_ext(certificate, extension.get(), -1) != 1) return false;
  }
  return true;
}

// All of a certificate but its extensions and signature.
X509Certificate unsigned_certificate(EVP_PKEY* key, int days) {
  X509Certificate out(X509_new());
  const bool good = out && X509_set_version(out.get(), X509_VERSION_3) == 1 &&
                    set_serial(out.get()) &&
                    X509_gmtime_adj(X509_getm_notBefore(out.get()), -kClockSkew) &&
                    X509_gmtime_adj(X509_getm_notAfter(out.get()), days * kSecondsOfDay) &&
                    X509_set_pubkey(out.get(), key) == 1;
  return good ? std::move(out) : nullptr;
}

std::string format_day(const ASN1_TIME* time) {
  std::tm parts{};
  std::array<char, 16> text{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return "";
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts)};
}

Result<Certificate> in_pem(X509* certificate, EVP_PKEY* key) {
  Certificate out;
  out.certificate = pem([=](BIO* to) { return PEM_write_bio_X509(to, certificate); });
  out.key = pem([=](BIO* to) {
    return PEM_write_bio_PKCS8PrivateKey(to, key, nullptr, nullptr, 0, nullptr, nullptr);
  });
  out.valid_until = format_day(X509_get0_notAfter(certificate));
  if (out.certificate.empty() || out.key.empty())
    return crypto_error("a certificate cannot be written as text");
  return out;
}

// Authorities of the same name would be taken for each other in error messages.
std::string authority_name(X509* certificate) {
  const Unique<BIGNUM, BN_free> serial(
      ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate), nullptr));
  if (!serial) return "Weir CA";
  const Unique<char, [](char* text) { OPENSSL_free(text); }> digits(BN_bn2hex(serial.get()));
  return "Weir CA " + std::string(digits.get()).substr(0, 8);
}

// "DNS:server,IP:10.0.0.5"
std::string alternative_names(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) {
    std::array<unsigned char, sizeof(in6_addr)> address{};
    const bool is_address = inet_pton(AF_INET, name.c_str(), address.data()) == 1 ||
                            inet_pton(AF_INET6, name.c_str(), address.data()) == 1;
    out += (out.empty() ? "" : ",") + std::string(is_address ? "IP:" : "DNS:") + name;
  }
  return out;
}

Status check_lifetime(X509* authority, X509* certificate, int days) {
  const ASN1_TIME* end = X509_get0_notAfter(authority);
  if (ASN1_TIME_compare(X509_get0_notAfter(certificate), end) <= 0) return ok();
  // The days left in a minute, in which the command with the fix is run.
  const Unique<ASN1_TIME, ASN1_TIME_free> soon(X509_gmtime_adj(nullptr, kSecondsToRetry));
  int left = 0, seconds = 0;
  ASN1_TIME_diff(&left, &seconds, soon.get(), end);
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the certificate would be valid for longer than its authority",
      .offered = "--days " + std::to_string(days),
      .needed = "an authority that is valid until then; this one expires on " + format_day(end),
      .fix = left > 0 ? "--days " + std::to_string(left) : "weir pki init NEW-FOLDER"};
}

}  // namespace

Result<Certificate> make_authority(int days) {
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return crypto_error("a key cannot be created");
  const X509Certificate certificate = unsigned_certificate(key.get(), days);
  X509* const self = certificate.get();
  const Extensions extensions{{NID_basic_constraints, "critical,CA:TRUE,pathlen:0"},
                              {NID_key_usage, "critical,keyCertSign,cRLSign"},
                              {NID_subject_key_identifier, "hash"}};
  if (!self || !set_subject(self, authority_name(self)) ||
      X509_set_issuer_name(self, X509_get_subject_name(self)) != 1 ||
      !add_extensions(self, self, extensions) || X509_sign(self, key.get(), EVP_sha256()) == 0)
    return crypto_error("the certificate of the authority cannot be created");
  return in_pem(self, key.get());
}

Result<Certificate> issue_certificate(const Certificate& authority,
                                      const std::vector<std::string>& names, int days) {
  const X509Certificate issuer(
      PEM_read_bio_X509(reader(authority.certificate).get(), nullptr, nullptr, nullptr));
  // An empty passphrase, so that OpenSSL does not ask at the terminal for one.
  const Key issuer_key(PEM_read_bio_PrivateKey(reader(authority.key).get(), nullptr, nullptr,
                                               const_cast<char*>("")));
  if (!issuer || !issuer_key) return authority_error("the authority cannot be read");
  if (X509_check_private_key(issuer.get(), issuer_key.get()) != 1)
    return authority_error("the key of the authority belongs to another certificate");
  if (X509_check_ca(issuer.get()) != 1)
    return authority_error("the certificate is not that of a certificate authority");
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return crypto_error("a key cannot be created");
  const X509Certificate certificate = unsigned_certificate(key.get(), days);
  X509* const made = certificate.get();
  const Extensions extensions{{NID_basic_constraints, "critical,CA:FALSE"},
                              {NID_key_usage, "critical,digitalSignature"},
                              {NID_ext_key_usage, "serverAuth,clientAuth"},
                              {NID_subject_key_identifier, "hash"},
                              {NID_authority_key_identifier, "keyid:always"},
                              {NID_subject_alt_name, alternative_names(names)}};
  if (!made || !set_subject(made, names.front()) ||
      X509_set_issuer_name(made, X509_get_subject_name(issuer.get())) != 1)
    return crypto_error("the certificate cannot be created");
  if (auto status = check_lifetime(issuer.get(), made, days); !status) return status.error();
  if (!add_extensions(made, issuer.get(), extensions) ||
      X509_sign(made, issuer_key.get(), EVP_sha256()) == 0)
    return crypto_error("the certificate cannot be created");
  return in_pem(made, key.get());
}

}  // namespace weir::app
