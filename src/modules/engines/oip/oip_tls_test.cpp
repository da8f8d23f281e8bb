// Connections with TLS to a server of Python's grpcio: authorities, certificates of servers and
// clients, tokens. OpenSSL's command makes the certificates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "oip/oip_test_support.hpp"

namespace weir::engine_test {
namespace oip_tls_test {

namespace fs = std::filesystem;

// ca, other-ca; server (127.0.0.1), expired, elsewhere (a name in another place), client; and
// stranger, a client of other-ca.
constexpr char kMakeCertificates[] = R"(
set -eu
# From OpenSSL 3.4 on, -days is 0 or more, and x509 has dates.
validity() {
  case $1 in -*) openssl x509 -help 2>&1 | grep -q not_after && echo -not_before 20200101000000Z -not_after 20200102000000Z && return ;; esac
  echo -days $1
}
authority() {
  openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj "/CN=$1" -days 2 -keyout $1.key -out $1.pem
}
certificate() { # NAME AUTHORITY SAN DAYS
  openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj "/CN=$1" -keyout $1.key -out $1.csr
  echo "subjectAltName=$3" > $1.ext
  openssl x509 -req -in $1.csr -CA $2.pem -CAkey $2.key -CAcreateserial -extfile $1.ext $(validity $4) -out $1.pem
}
authority ca
authority other-ca
certificate server ca IP:127.0.0.1 2
certificate expired ca IP:127.0.0.1 -1
certificate elsewhere ca DNS:elsewhere.example 2
certificate client ca DNS:client 2
certificate stranger other-ca DNS:stranger 2
)";

class OipTls : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = fs::temp_directory_path() / "oip-tls-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    std::ofstream(folder_ / "make") << kMakeCertificates;
    const std::string line = "cd " + name + " && sh make > log 2>&1";
    ASSERT_EQ(std::system(line.c_str()), 0) << "openssl failed, or apt-get install openssl";
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static std::string file(const std::string& name) { return folder_ / name; }
  // Arguments of a server with this certificate.
  static std::vector<std::string> with(const std::string& certificate,
                                       std::vector<std::string> more = {}) {
    more.insert(more.end(),
                {"--cert=" + file(certificate + ".pem"), "--key=" + file(certificate + ".key")});
    return more;
  }
  static std::string token(const std::string& text) {
    std::ofstream(folder_ / "token") << text;
    return file("token");
  }
  OipEngine::Options trusting(const OipEngine::Options& more = {}) const {
    OipEngine::Options out{{"ca", file("ca.pem")}};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  static void expect_response(OipEngine* engine) {
    ASSERT_EQ(engine->error().what, "");
    const auto result =
        engine->invoke(make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3}));
    ASSERT_EQ(result.code, 0);
    const std::vector<float> expected{1, 3, 5, 7};
    EXPECT_EQ(std::memcmp(result.bytes.data(), expected.data(), sizeof(float) * 4), 0);
  }
  static void expect_unreachable(const OipEngine& engine, const std::string& reason) {
    EXPECT_EQ(engine.error().code, Code::SERVER_UNREACHABLE);
    EXPECT_NE(engine.error().offered.find(reason), std::string::npos) << engine.error().message();
  }

 private:
  static inline fs::path folder_;
};

TEST_F(OipTls, AServerOfTheAuthorityAnswers) {
  PythonServer server(with("server"));
  OipEngine engine({server.address("grpcs")}, trusting());
  expect_response(&engine);
}

TEST_F(OipTls, AServerOfAnotherAuthorityIsNotTrusted) {
  PythonServer server(with("server"));
  OipEngine other({server.address("grpcs")}, {{"ca", file("other-ca.pem")}});
  expect_unreachable(other, "certificate verify failed");
  OipEngine systems({server.address("grpcs")});
  expect_unreachable(systems, "certificate verify failed");
}

TEST_F(OipTls, AnExpiredCertificateIsNotTrusted) {
  PythonServer server(with("expired"));
  OipEngine engine({server.address("grpcs")}, trusting());
  expect_unreachable(engine, "certificate verify failed");
}

TEST_F(OipTls, ACertificateOfAnotherNameIsNotTrusted) {
  PythonServer server(with("elsewhere"));
  OipEngine engine({server.address("grpcs")}, trusting());
  expect_unreachable(engine, "127.0.0.1");
}

TEST_F(OipTls, AServerThatKnowsItsClientsAnswersThem) {
  PythonServer server(with("server", {"--ca=" + file("ca.pem")}));
  OipEngine engine({server.address("grpcs")},
                   trusting({{"cert", file("client.pem")}, {"key", file("client.key")}}));
  expect_response(&engine);
}

TEST_F(OipTls, AServerThatKnowsItsClientsAnswersNoOthers) {
  PythonServer server(with("server", {"--ca=" + file("ca.pem")}));
  OipEngine without({server.address("grpcs")}, trusting());
  EXPECT_EQ(without.error().code, Code::SERVER_UNREACHABLE);
  OipEngine stranger({server.address("grpcs")},
                     trusting({{"cert", file("stranger.pem")}, {"key", file("stranger.key")}}));
  EXPECT_EQ(stranger.error().code, Code::SERVER_UNREACHABLE);
}

TEST_F(OipTls, ATokenIsSentWithEachRequest) {
  PythonServer server(with("server", {"--token=secret"}));
  OipEngine engine({server.address("grpcs")},
                   trusting({{"token-file", token("\nsecret\r\nother\n")}}));
  expect_response(&engine);
}

TEST_F(OipTls, AWrongTokenIsRefusedWithTheServersText) {
  PythonServer server(with("server", {"--token=secret"}));
  OipEngine wrong({server.address("grpcs")}, trusting({{"token-file", token("guess")}}));
  EXPECT_EQ(wrong.error().code, Code::SERVER_REFUSED);
  EXPECT_NE(wrong.error().offered.find("a token is needed (gRPC status 16)"), std::string::npos);
  OipEngine none({server.address("grpcs")}, trusting());
  EXPECT_EQ(none.error().code, Code::SERVER_REFUSED);
}

TEST_F(OipTls, ARequestWithAWrongTokenCountsAsRefused) {
  PythonServer server(with("server", {"--token=secret", "--no-metadata"}));
  OipEngine engine({server.address("grpcs")}, trusting({{"token-file", token("guess")},
                                                        {"input", "4:1"},
                                                        {"inputtype", "float32"},
                                                        {"inputname", "x"},
                                                        {"output", "4:1"},
                                                        {"outputtype", "float32"},
                                                        {"outputname", "y"}}));
  ASSERT_EQ(engine.error().what, "");
  EXPECT_EQ(engine.invoke(make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3})).code,
            WEIR_RESULT_REFUSED);
  const auto counts = engine.statistics();
  EXPECT_EQ(counts.at("requests-refused"), 1u);
  EXPECT_EQ(counts.at("request-attempts"), 1u);
}

TEST_F(OipTls, ATokenIsNotSentWithoutTls) {
  OipEngine engine({"grpc://127.0.0.1:9/affine"},
                   {{"token-file", token("secret")}, {"insecure", "true"}});
  EXPECT_EQ(engine.error().code, Code::CONNECTION_INSECURE);
  EXPECT_EQ(engine.error().what, "a token would be sent without TLS");
  EXPECT_EQ(engine.error().fix, "model=grpcs://127.0.0.1:9/affine");
}

TEST_F(OipTls, OneSideWithoutTlsIsUnreachable) {
  PythonServer encrypted(with("server")), plain;
  OipEngine one({encrypted.address("grpc")});
  EXPECT_EQ(one.error().code, Code::SERVER_UNREACHABLE);
  OipEngine other({plain.address("grpcs")}, trusting());
  EXPECT_EQ(other.error().code, Code::SERVER_UNREACHABLE);
}

TEST_F(OipTls, FilesThatCannotBeUsedAreErrors) {
  OipEngine half({"grpcs://127.0.0.1:9/m"}, trusting({{"cert", file("client.pem")}}));
  EXPECT_EQ(half.error().what, "a certificate and its key belong together");
  OipEngine missing({"grpcs://127.0.0.1:9/m"}, {{"ca", file("nowhere.pem")}});
  EXPECT_EQ(missing.error().what, "the file of the option ca cannot be read");
  EXPECT_EQ(missing.error().offered, file("nowhere.pem"));
  OipEngine empty({"grpcs://127.0.0.1:9/m"}, trusting({{"token-file", token("")}}));
  EXPECT_EQ(empty.error().what, "the file of the option token-file cannot be read");
  OipEngine blank({"grpcs://127.0.0.1:9/m"}, trusting({{"token-file", token("\n\r\n")}}));
  EXPECT_EQ(blank.error().what, "the file of the option token-file has no token");
}

// gRPC ends a process that sends them.
TEST_F(OipTls, TokensThatCannotBeSentAreErrors) {
  PythonServer server(with("server", {"--token=secret"}));
  for (const auto* text : {"\xEF\xBB\xBFsecret\n", "sec\tret", "secr\xC3\xA9t", "\x7f"}) {
    OipEngine engine({server.address("grpcs")}, trusting({{"token-file", token(text)}}));
    EXPECT_EQ(engine.error().code, Code::OPTION_VALUE);
    EXPECT_EQ(engine.error().what,
              "the file of the option token-file has a token that cannot be sent");
    EXPECT_NE(engine.error().offered.find(" of line 1 of " + file("token")), std::string::npos);
  }
}

}  // namespace oip_tls_test
}  // namespace weir::engine_test
