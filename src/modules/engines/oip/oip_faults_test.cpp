// Servers that fail, are slow, stop or lie; addresses and options that cannot be used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_test_support.hpp"

namespace weir::engine_test {
namespace oip_faults_test {

using namespace std::chrono_literals;

TestTensor floats() {
  return make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3});
}

uint64_t ended(std::map<std::string, uint64_t> s) {
  return s["requests-answered"] + s["requests-late"] + s["requests-refused"] + s["requests-lost"];
}

TEST(OipFaults, ASecondServerAnswersWhenTheFirstIsKilled) {
  PythonServer first, second;
  OipEngine engine({first.address(), second.address()});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(engine.invoke(floats()).code, 0);
  first.end();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(engine.invoke(floats()).code, 0);
  const auto statistics = engine.statistics();
  EXPECT_EQ(statistics.at("requests-answered"), 30u);
  EXPECT_EQ(statistics.at("requests-sent"), 30u);
  EXPECT_LE(statistics.at("request-attempts"), 33u);  // two losses open the circuit
}

TEST(OipFaults, ASecondServerAnswersWhenTheFirstIsStopped) {
  PythonServer first, second;
  OipEngine engine({first.address(), second.address()}, {{"timeout-ms", "4000"}});
  for (int i = 0; i < 30; ++i) ASSERT_EQ(engine.invoke(floats()).code, 0);
  first.signal(SIGSTOP);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(engine.invoke(floats()).code, 0);
  first.signal(SIGCONT);
  EXPECT_EQ(engine.statistics()["requests-answered"], 50u);
}

TEST(OipFaults, AStoppedServerMakesRequestsLateAtTheEarlierDeadline) {
  PythonServer server;
  const auto engine = opened({server.address()}, {{"timeout-ms", "300"}});
  OipEngine patient({server.address()}, {{"timeout-ms", "86400000"}});
  ASSERT_TRUE(becomes_true([&] { return engine->invoke(floats()).code == 0; }, "an answer"));
  ASSERT_EQ(patient.invoke(floats()).code, 0);
  const uint64_t late = engine->statistics()["requests-late"];
  server.signal(SIGSTOP);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(engine->invoke(floats()).code, WEIR_RESULT_LATE);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 290ms);
  EXPECT_EQ(patient.invoke(floats(), 50).code, WEIR_RESULT_LATE);  // not after a day
  server.signal(SIGCONT);
  EXPECT_EQ(engine->statistics()["requests-late"], late + 1);
  EXPECT_EQ(patient.statistics()["requests-late"], 1u);
}

TEST(OipFaults, ARestartedServerIsUsedAgainSoon) {
  auto server = std::make_unique<PythonServer>();
  const std::string port = server->port();
  OipEngine engine({server->address()});
  ASSERT_EQ(engine.invoke(floats()).code, 0);
  const auto restart = [&] {
    server->end();
    for (int i = 0; i < 3; ++i) EXPECT_EQ(engine.invoke(floats()).code, WEIR_RESULT_LOST);
    server = std::make_unique<PythonServer>(std::vector<std::string>{"--port", port});
    ASSERT_EQ(server->port(), port);
  };
  const auto responds = [&] {
    EXPECT_TRUE(becomes_true([&] { return engine.invoke(floats()).code == 0; }, "an answer"));
  };
  // gRPC looks at connections without a call each 5 s only; probes must connect on their own.
  EXPECT_TRUE(is_quick(restart, responds, 3s));
  const auto statistics = engine.statistics();
  EXPECT_EQ(statistics.at("requests-sent"), ended(statistics));
}

TEST(OipFaults, StartsWithAServerThatIsNotThereYet) {
  PythonServer server;
  OipEngine engine({"grpc://127.0.0.1:9/affine/1", server.address()});
  ASSERT_EQ(engine.error().what, "");
  EXPECT_EQ(engine.invoke(floats()).code, 0);
  EXPECT_EQ(engine.statistics()["request-attempts"], 1u);
}

TEST(OipFaults, RefusesResponsesOfAnotherShapeTypeOrSize) {
  for (const auto* behaviour :
       {"wrong-shape", "wrong-type", "short", "extra-raw", "no-output", "huge", "damaged"}) {
    PythonServer server({"--behaviour", behaviour});
    OipEngine engine({server.address()});
    take_log();
    EXPECT_EQ(engine.invoke(floats()).code, WEIR_RESULT_REFUSED) << behaviour;
    EXPECT_EQ(engine.invoke(floats(), 0, 16).code, WEIR_RESULT_REFUSED) << behaviour;
    EXPECT_EQ(engine.statistics()["requests-refused"], 2u) << behaviour;
    const auto log = take_log();
    ASSERT_EQ(log.size(), 1u) << behaviour;
    EXPECT_NE(log[0].find("a request is refused: " + server.address()), std::string::npos)
        << log[0];
    EXPECT_NE(log[0].find("WEIR-6004"), std::string::npos) << log[0];
  }
}

TEST(OipFaults, CountsAnInternalErrorAsLostAfterItsAttempts) {
  PythonServer server({"--behaviour", "error"});
  OipEngine engine({server.address()});
  EXPECT_EQ(engine.invoke(floats()).code, WEIR_RESULT_LOST);
  const auto statistics = engine.statistics();
  EXPECT_EQ(statistics.at("requests-lost"), 1u);
  EXPECT_EQ(statistics.at("request-attempts"), 2u);
}

TEST(OipFaults, ChecksTheFrameBeforeSendingIt) {
  PythonServer server;
  OipEngine engine({server.address()});
  const auto result =
      engine.invoke(make_tensor(WEIR_FLOAT32, {1, 5}, std::vector<float>{1, 2, 3, 4, 5}));
  EXPECT_EQ(result.code, -WEIR_SPEC_MISMATCH);
  EXPECT_EQ(engine.statistics()["requests-sent"], 0u);
}

TEST(OipFaults, NamesTheServerThatCannotBeReached) {
  OipEngine engine({"grpc://127.0.0.1:9/affine/1"});
  EXPECT_EQ(engine.error().code, Code::SERVER_UNREACHABLE);
  EXPECT_EQ(engine.error().offered.find("grpc://127.0.0.1:9/affine/1: "), 0u);
  EXPECT_EQ(engine.error().fix, "start the server, or correct model=grpc://127.0.0.1:9/affine/1");
}

TEST(OipFaults, KeepsTheLogOfGrpcOffStandardError) {
  PythonServer server;
  take_log();
  testing::internal::CaptureStderr();
  OipEngine engine({server.address("grpcs")}, {{"timeout-ms", "60000"}});  // the server has no TLS
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(engine.error().code, Code::SERVER_UNREACHABLE);
  const auto log = take_log();
  EXPECT_TRUE(std::any_of(log.begin(), log.end(), [](const auto& line) {
    return line.find("gRPC: Handshake failed") != std::string::npos;
  })) << testing::PrintToString(log);
}

TEST(OipFaults, PassesOnWhatTheServerSays) {
  PythonServer server;
  OipEngine engine({"grpc://127.0.0.1:" + server.port() + "/other/1"});
  EXPECT_EQ(engine.error().code, Code::SERVER_REFUSED);
  EXPECT_NE(engine.error().offered.find("there is no model other (gRPC status 5)"),
            std::string::npos);
}

TEST(OipFaults, RefusesServersOfDifferentModels) {
  PythonServer one, other({"--shape=-1,5"});
  OipEngine engine({one.address(), other.address()});
  EXPECT_EQ(engine.error().what, "two servers have different models");
  EXPECT_EQ(engine.error().offered,
            other.address() + ": inputs x FP32 [-1,5]; outputs y FP32 [-1,5]");
}

TEST(OipFaults, RefusesToConnectToOtherMachinesWithoutTls) {
  OipEngine engine({"grpc://192.0.2.1:8001/m"});
  EXPECT_EQ(engine.error().code, Code::CONNECTION_INSECURE);
  EXPECT_EQ(engine.error().fix, "model=grpcs://192.0.2.1:8001/m");
  OipEngine token({"grpc://127.0.0.1:8001/m"}, {{"token-file", "/dev/null"}});
  EXPECT_EQ(token.error().what, "a token would be sent without TLS");
}

TEST(OipFaults, RefusesOptionsThatCannotBeUsed) {
  const struct {
    const char *key, *value, *what;
  } cases[] = {{"attempts", "0", "the option attempts has a value that cannot be used"},
               {"timeout-ms", "soon", "the option timeout-ms has a value that cannot be used"},
               {"contents", "json", "the option contents has a value that cannot be used"},
               {"insecure", "maybe", "the option insecure has a value that cannot be used"},
               {"ca", "/nowhere", "certificates have no effect on a connection without TLS"}};
  for (const auto& c : cases) {
    OipEngine engine({"grpc://127.0.0.1:9/m"}, {{c.key, c.value}});
    EXPECT_EQ(engine.error().what, c.what);
  }
  OipEngine missing({"grpcs://127.0.0.1:9/m"}, {{"ca", "/nowhere"}});
  EXPECT_EQ(missing.error().code, Code::FILE_NOT_FOUND);
}

}  // namespace oip_faults_test
}  // namespace weir::engine_test
