// Requests to a server of another implementation: Python's grpcio with the classes that protoc
// makes. The expected values are y = 2 x + 1.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <thread>

#include "becomes.hpp"
#include "oip/oip_test_support.hpp"

namespace weir::engine_test {
namespace oip_test {

template <class T>
std::vector<T> as(const std::vector<std::byte>& bytes) {
  std::vector<T> out(bytes.size() / sizeof(T));
  std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
  return out;
}

TestTensor floats(const std::vector<float>& values = {0, 1, 2, 3}) {
  return make_tensor(WEIR_FLOAT32, {1, static_cast<int64_t>(values.size())}, values);
}
const std::vector<float> kExpected{1, 3, 5, 7};

TEST(Oip, NegotiatesAndComputes) {
  PythonServer server;
  ASSERT_NE(server.port(), "");
  OipEngine engine({server.address()});
  ASSERT_EQ(engine.error().what, "");
  ASSERT_EQ(engine.info().n_inputs, 1u);
  EXPECT_STREQ(engine.info().inputs[0].name, "x");
  EXPECT_EQ(to_string(engine.info().inputs[0]), "float32[-1, 4]");
  EXPECT_EQ(engine.info().inputs[0].batch_axis, 0u);
  const auto result = engine.invoke(floats());
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(as<float>(result.bytes), kExpected);
  EXPECT_EQ(result.shape, (std::vector<int64_t>{1, 4}));
}

TEST(Oip, NamesTheServerThatAnsweredTheCallingThread) {
  PythonServer server;
  OipEngine engine({server.address()});
  ASSERT_EQ(engine.error().what, "");
  ASSERT_EQ(engine.invoke(floats()).code, 0);
  EXPECT_EQ(engine.answered_by(), server.address());
  std::thread other([&] {
    EXPECT_EQ(engine.answered_by(), "");
    EXPECT_EQ(engine.invoke(floats()).code, 0);
    EXPECT_EQ(engine.answered_by(), server.address());
  });
  other.join();
}

template <class T>
void check_type(const char* name, uint32_t type, const std::vector<std::string>& more,
                const std::string& contents) {
  std::vector<std::string> arguments{"--type", name, "--shape", "1,3"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  PythonServer server(arguments);
  OipEngine engine({server.address()}, {{"contents", contents}});
  ASSERT_EQ(engine.error().what, "") << name;
  const std::vector<T> x{T(0), T(7), T(50)}, y{T(1), T(15), T(101)};
  const auto result = engine.invoke(make_tensor(type, {1, 3}, x), 0, 3 * sizeof(T));
  ASSERT_EQ(result.code, 0) << name << " " << contents;
  EXPECT_EQ(as<T>(result.bytes), y) << name << " " << contents;
}

TEST(Oip, SendsAndReadsEveryTypeRawAndTyped) {
  for (const auto* contents : {"raw", "typed"})
    for (const auto& more : {std::vector<std::string>{}, std::vector<std::string>{"--typed"}}) {
      check_type<int8_t>("INT8", WEIR_INT8, more, contents);
      check_type<int64_t>("INT64", WEIR_INT64, more, contents);
      check_type<uint16_t>("UINT16", WEIR_UINT16, more, contents);
      check_type<float>("FP32", WEIR_FLOAT32, more, contents);
      check_type<double>("FP64", WEIR_FLOAT64, more, contents);
    }
}

TEST(Oip, SendsNegativeIntegersAsTypedContents) {
  PythonServer server({"--type", "INT32", "--shape", "1,2", "--typed"});
  OipEngine engine({server.address()}, {{"contents", "typed"}});
  const auto result = engine.invoke(make_tensor(WEIR_INT32, {1, 2}, std::vector<int32_t>{-5, 3}));
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(as<int32_t>(result.bytes), (std::vector<int32_t>{-9, 7}));
}

TEST(Oip, SendsHalvesRaw) {
  PythonServer server({"--type", "FP16", "--shape", "1,2"});
  OipEngine engine({server.address()});
  // 1.0 and -0.5 become 3.0 and 0.0.
  const auto result =
      engine.invoke(make_tensor(WEIR_FLOAT16, {1, 2}, std::vector<uint16_t>{0x3C00, 0xB800}));
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(as<uint16_t>(result.bytes), (std::vector<uint16_t>{0x4200, 0x0000}));
}

TEST(Oip, SendsBytesAsOneElement) {
  for (const auto* contents : {"raw", "typed"}) {
    PythonServer server({"--type", "BYTES", "--shape", "1"});
    OipEngine engine({server.address()}, {{"contents", contents}});
    EXPECT_EQ(to_string(engine.info().inputs[0]), "uint8[-1]");
    const auto result = engine.invoke(make_tensor(WEIR_UINT8, {3}, std::vector<uint8_t>{1, 2, 3}));
    ASSERT_EQ(result.code, 0) << contents;
    EXPECT_EQ(as<uint8_t>(result.bytes), (std::vector<uint8_t>{3, 2, 1}));
    EXPECT_EQ(result.shape, std::vector<int64_t>{3});
  }
}

TEST(Oip, TurnsToTypedContentsWhenRawOnesAreRefused) {
  PythonServer server({"--behaviour", "refuses-raw"});
  OipEngine automatic({server.address()}), raw({server.address()}, {{"contents", "raw"}});
  for (int i = 0; i < 2; ++i) EXPECT_EQ(as<float>(automatic.invoke(floats()).bytes), kExpected);
  EXPECT_EQ(automatic.statistics()["requests-refused"], 1u);
  EXPECT_EQ(raw.invoke(floats()).code, WEIR_RESULT_REFUSED);
}

TEST(Oip, CopiesNothingOutAndOnceIn) {
  PythonServer server({"--shape", "1,100000"});
  const std::vector<float> x(100000, 2);
  OipEngine engine({server.address()});
  let_hold_frames(true);
  const auto result = engine.invoke(floats(x), 0, 400000);
  let_hold_frames(false);
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(as<float>(result.bytes), std::vector<float>(100000, 5));
  const auto statistics = engine.statistics();
  EXPECT_EQ(statistics.at("request-bytes-copied"), 0u);
  EXPECT_EQ(statistics.at("answer-bytes-copied"), 400000u);
  EXPECT_EQ(engine.invoke(floats(x)).code, 0);  // the host keeps no memory: one copy
  EXPECT_EQ(engine.statistics()["request-bytes-copied"], 400000u);
  EXPECT_TRUE(becomes_true([] { return held_frames() == 0; }, "the end of the held frames"));
}

TEST(Oip, WorksThroughAUnixSocket) {
  TemporaryFolder folder;
  PythonServer server({"--address", "unix:" + folder.path("socket")});
  OipEngine engine({"grpc+unix:" + folder.path("socket") + ":/affine/1"});
  ASSERT_EQ(engine.error().what, "");
  EXPECT_EQ(as<float>(engine.invoke(floats()).bytes), kExpected);
}

TEST(Oip, NeedsDeclaredTensorsForAServerWithoutDescription) {
  PythonServer server({"--no-metadata"});
  OipEngine without({server.address()});
  EXPECT_EQ(without.error().code, Code::SERVER_REFUSED);
  OipEngine with({server.address()}, {{"input", "4:1"},
                                      {"inputtype", "float32"},
                                      {"inputname", "x"},
                                      {"output", "4:1"},
                                      {"outputtype", "float32"},
                                      {"outputname", "y"}});
  ASSERT_EQ(with.error().what, "");
  EXPECT_EQ(as<float>(with.invoke(floats()).bytes), kExpected);
}

TEST(Oip, RunsRequestsOfSeveralThreadsAtOnce) {
  PythonServer server({"--delay", "0.2"});
  OipEngine engine({server.address()});
  std::vector<std::jthread> threads;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&, i] {
      for (int k = 0; k < 5; ++k) {
        const auto x = static_cast<float>(10 * i + k);
        const auto result = engine.invoke(floats({x, x, x, x}));
        EXPECT_EQ(as<float>(result.bytes), std::vector<float>(4, 2 * x + 1));
      }
    });
  threads.clear();
  // One after the other they take 4 s.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(4));
  EXPECT_EQ(engine.statistics()["requests-answered"], 20u);
}

TEST(Oip, ReportsEachServer) {
  // The clock of the first server is an hour ahead; the second one refuses any parameter.
  PythonServer timed({"--times", "3600", "--delay", "0.01"}), foreign;
  OipEngine engine({timed.address(), foreign.address()}, {{"in-flight", "1"}});
  for (int i = 0; i < 20; ++i) EXPECT_EQ(as<float>(engine.invoke(floats()).bytes), kExpected);
  const auto servers = engine.servers();
  ASSERT_EQ(servers.size(), 2u);
  EXPECT_EQ(servers[0].address, timed.address());
  EXPECT_EQ(servers[1].address, foreign.address());
  for (const auto& server : servers) {
    EXPECT_EQ(server.answered, 10u);
    EXPECT_EQ(server.late + server.refused + server.lost, 0u);
    EXPECT_EQ(server.in_flight, 0u);
    EXPECT_EQ(server.circuit, WEIR_CIRCUIT_CLOSED);
    EXPECT_GT(server.bytes_sent, 10 * kExpected.size() * sizeof(float));
    EXPECT_GT(server.bytes_received, 10 * kExpected.size() * sizeof(float));
    EXPECT_GT(server.p50_us, 0);
    EXPECT_LE(server.p50_us, server.p95_us);
    EXPECT_LE(server.p95_us, server.p99_us);
  }
  EXPECT_GE(servers[0].p50_us, 10000);
  EXPECT_EQ(servers[0].queue_us, 1500);
  EXPECT_EQ(servers[0].compute_us, 2500);
  ASSERT_GE(servers[0].clock_error_ns, 0);
  EXPECT_LE(std::abs(servers[0].clock_offset_ns - int64_t{3'600'000'000'000}),
            servers[0].clock_error_ns);
  EXPECT_LT(servers[0].clock_error_ns, int64_t{1'000'000'000});
  EXPECT_EQ(servers[1].queue_us, -1);
  EXPECT_EQ(servers[1].clock_error_ns, -1);
}

TEST(Oip, ReportsWhatAServerLost) {
  PythonServer gone, other;
  OipEngine engine({gone.address(), other.address()}, {{"in-flight", "1"}});
  gone.end();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(as<float>(engine.invoke(floats()).bytes), kExpected);
  const auto servers = engine.servers();
  ASSERT_EQ(servers.size(), 2u);
  EXPECT_EQ(servers[0].answered, 0u);
  EXPECT_EQ(servers[0].lost, 2u);
  EXPECT_NE(servers[0].circuit, WEIR_CIRCUIT_CLOSED);
  EXPECT_EQ(servers[0].p50_us, -1);
  EXPECT_EQ(servers[1].answered, 10u);
  EXPECT_EQ(engine.statistics()["requests-lost"], 0u);
}

}  // namespace oip_test
}  // namespace weir::engine_test
