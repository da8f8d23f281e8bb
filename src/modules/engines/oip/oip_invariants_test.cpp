// What holds for every request, whatever happens to servers and connections: it ends once, in time,
// and a response is that of its own frame. Faults come from tests/support/fault_proxy.py by seed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <malloc.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

#include "oip/oip_test_support.hpp"

namespace weir::engine_test {
namespace oip_invariants_test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class FaultProxy : public PythonProcess {
 public:
  FaultProxy(const PythonServer& server, int seed, const std::vector<std::string>& faults = {})
      : PythonProcess(WEIR_FAULT_PROXY, arguments(server, seed, faults)) {}
  // Resets all connections; returns the number of those accepted so far.
  int drop() const { return std::stoi(response_to("drop").substr(sizeof "dropped")); }

 private:
  static std::vector<std::string> arguments(const PythonServer& server, int seed,
                                            const std::vector<std::string>& faults) {
    std::vector<std::string> out{"--to", server.port(), "--seed", std::to_string(seed)};
    for (const auto& fault : faults) out.insert(out.end(), {"--fault", fault});
    return out;
  }
};

struct Ends {
  std::atomic<uint64_t> answered{0}, late{0}, refused{0}, lost{0}, other{0};
  std::atomic<uint64_t> wrong{0};    // responses that are not those of their frames
  std::atomic<uint64_t> overdue{0};  // ended later than one second after their deadline
  uint64_t all() const { return answered + late + refused + lost; }
};

struct Load {
  int requests, threads, limit;  // limit: milliseconds, of each request
  bool expires = false;          // the limit is the frame's deadline, not timeout-ms
  // Called by the thread that sends this request, before it does.
  std::function<void(int)> at = [](int) {};
};

void count(const OipEngine::Result& result, const std::vector<float>& x, Ends* ends) {
  switch (result.code) {
    case 0: {
      ++ends->answered;
      std::vector<float> y(x.size());
      if (result.bytes.size() == x.size() * sizeof(float))
        std::memcpy(y.data(), result.bytes.data(), result.bytes.size());
      for (size_t i = 0; i < x.size(); ++i)
        if (y[i] != 2 * x[i] + 1) {
          ++ends->wrong;
          break;
        }
      return;
    }
    case WEIR_RESULT_LATE:
      ++ends->late;
      return;
    case WEIR_RESULT_REFUSED:
      ++ends->refused;
      return;
    case WEIR_RESULT_LOST:
      ++ends->lost;
      // The next frame of a camera: without a pause, one outage would take all requests.
      std::this_thread::sleep_for(5ms);
      return;
    default:
      ++ends->other;
  }
}

void send(OipEngine& engine, const Load& load, Ends* ends) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < load.requests; i = next++) {
      load.at(i);
      const auto number = static_cast<float>(i);
      const std::vector<float> x{number, number + 0.5F, -number, 1};
      const auto begin = Clock::now();
      const auto result =
          engine.invoke(make_tensor(WEIR_FLOAT32, {1, 4}, x), load.expires ? load.limit : 0);
      if (Clock::now() - begin > std::chrono::milliseconds(load.limit) + 1s) ++ends->overdue;
      count(result, x, ends);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < load.threads; ++i) threads.emplace_back(work);
  for (auto& thread : threads) thread.join();
}

void expect_sums(const OipEngine& engine, const Ends& ends, uint64_t requests) {
  auto statistics = engine.statistics();
  EXPECT_EQ(ends.all(), requests);
  EXPECT_EQ(ends.other, 0u);
  EXPECT_EQ(ends.overdue, 0u);
  EXPECT_EQ(statistics["requests-sent"], requests);
  EXPECT_EQ(statistics["requests-answered"], ends.answered);
  EXPECT_EQ(statistics["requests-late"], ends.late);
  EXPECT_EQ(statistics["requests-refused"], ends.refused);
  EXPECT_EQ(statistics["requests-lost"], ends.lost);
}

size_t open_files() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<size_t>(std::distance(begin(all), end(all)));
}

TEST(OipLaws, TenThousandRequestsEndOnceInTimeWithTheirOwnResponses) {
  constexpr int kRequests = 10000, kLimit = 400;
  PythonServer first, second;
  const std::vector<std::string> faults{"delay=0.05", "stall=0.002", "cut=0.004", "half=0.002",
                                        "reset=0.004"};
  FaultProxy one(first, 1, faults), two(second, 2, faults);
  const auto engine =
      opened({affine_at(one.port()), affine_at(two.port())},
             {{"timeout-ms", std::to_string(kLimit)}, {"probe-ms", "20"}, {"in-flight", "8"}});
  Ends ends;
  send(*engine,
       {.requests = kRequests,
        .threads = 8,
        .limit = kLimit,
        .at =
            [&](int i) {
              if (i == 3000) second.signal(SIGSTOP);
              if (i == 5000) second.signal(SIGCONT);
              if (i == 8000) first.end();
            }},
       &ends);
  expect_sums(*engine, ends, kRequests);
  EXPECT_EQ(ends.wrong, 0u);
  EXPECT_GT(ends.answered, kRequests / 10u);
  EXPECT_GT(ends.late + ends.lost, 0u);
}

// TCP does not notice such bytes either: a response may be that of a changed frame.
TEST(OipLaws, ChangedBytesEndRequestsOnceAndInTime) {
  constexpr int kRequests = 2000, kLimit = 400;
  PythonServer server;
  FaultProxy proxy(server, 3, {"flip=0.05"});
  const auto engine = opened({affine_at(proxy.port())},
                             {{"timeout-ms", std::to_string(kLimit)}, {"probe-ms", "20"}});
  Ends ends;
  send(*engine, {.requests = kRequests, .threads = 4, .limit = kLimit}, &ends);
  expect_sums(*engine, ends, kRequests);
  EXPECT_GT(ends.answered, 0u);
}

TEST(OipLaws, AThousandReconnectsLeaveNoMemoryAndNoFiles) {
  constexpr int kReconnects = 1000, kWarm = 100;
  PythonServer server;
  FaultProxy proxy(server, 4);
  OipEngine engine({affine_at(proxy.port())}, {{"probe-ms", "1"}, {"attempts", "3"}});
  ASSERT_EQ(engine.error().what, "");
  size_t files = 0;
  uint64_t memory = 0, answered = 0;
  int connections = 0;
  for (int i = 0; connections < kReconnects; ++i) {
    ASSERT_LT(i, 3 * kReconnects) << "only " << connections << " connections";
    answered +=
        engine.invoke(make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3})).code == 0;
    if (i == kWarm) files = open_files(), memory = mallinfo2().uordblks;
    connections = proxy.drop();
  }
  EXPECT_LE(open_files(), files + 2);  // a connection may be closing
  EXPECT_LE(mallinfo2().uordblks, memory + (512 << 10));
  EXPECT_GT(answered, kReconnects * 9u / 10);
}

TEST(OipLaws, AStormOfCancelledRequestsEndsAndTheServerIsUsedAfterIt) {
  constexpr int kRequests = 2000;
  PythonServer server({"--delay", "0.01"});
  OipEngine engine({server.address()}, {{"probe-ms", "1"}, {"in-flight", "64"}});
  ASSERT_EQ(engine.error().what, "");
  Ends ends;
  send(engine, {.requests = kRequests, .threads = 16, .limit = 3, .expires = true}, &ends);
  expect_sums(engine, ends, kRequests);
  EXPECT_GT(ends.late, 0u);
  const auto limit = Clock::now() + 60s;
  int code = 1;
  while (code != 0 && Clock::now() < limit)
    code = engine.invoke(make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3})).code;
  EXPECT_EQ(code, 0);
}

TEST(OipLaws, AModelIsClosedInEveryStateOfItsServer) {
  const auto x = make_tensor(WEIR_FLOAT32, {1, 4}, std::vector<float>{0, 1, 2, 3});
  PythonServer there, stopped, killed;
  for (int i = 0; i < 10; ++i) {
    OipEngine idle({there.address()});
    EXPECT_EQ(idle.error().what, "");
  }
  OipEngine probing({there.address(), "grpc://127.0.0.1:9/affine/1"}, {{"probe-ms", "1"}});
  EXPECT_EQ(probing.invoke(x).code, 0);
  OipEngine hangs({stopped.address()}, {{"probe-ms", "1"}});
  OipEngine gone({killed.address()}, {{"probe-ms", "1"}});
  stopped.signal(SIGSTOP);
  killed.end();
  for (int i = 0; i < 4; ++i) {
    EXPECT_NE(hangs.invoke(x, 50).code, 0);
    EXPECT_EQ(gone.invoke(x).code, WEIR_RESULT_LOST);
  }
}

}  // namespace oip_invariants_test
}  // namespace weir::engine_test
