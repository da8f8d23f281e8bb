// What a client measures of a server: percentiles, the offset of its clock, times of responses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "net/client/clock_offset.hpp"
#include "net/client/latencies.hpp"
#include "net/protocol/oip_messages.hpp"
#include "net/protocol/oip_service_messages.hpp"

namespace weir::net {
namespace link_statistics_test {

using namespace std::chrono_literals;

std::string text_of(const Pieces& pieces) {
  std::string out;
  for (const auto& piece : pieces) out += piece.own;
  return out;
}

Chunks chunks_of(const std::string& text) {
  return Chunks({std::as_bytes(std::span(text))});
}

TEST(Latencies, ArePercentilesOfTheLastRequests) {
  Latencies latencies;
  for (int i = 1; i <= 7; ++i) latencies.add(1h);
  EXPECT_FALSE(latencies.percentile(50));
  for (int i = 1; i <= 256; ++i) latencies.add(i * 1ms);  // the hours are forgotten
  EXPECT_EQ(latencies.percentile(0), 1ms);
  EXPECT_EQ(latencies.percentile(50), 129ms);
  EXPECT_EQ(latencies.percentile(95), 244ms);
  EXPECT_EQ(latencies.percentile(99), 254ms);
}

TEST(ClockOffset, IsExactWhenBothWaysTakeTheSameTime) {
  ClockOffset clock;
  EXPECT_FALSE(clock.estimate());
  clock.add(100, 1120, 1150, 170);  // 1000 ahead, 20 on each way
  EXPECT_EQ(clock.estimate()->offset, 1000);
  EXPECT_EQ(clock.estimate()->error, 20);
}

TEST(ClockOffset, HasTheTrueOffsetWithinItsError) {
  constexpr int64_t kAhead = -5'000'000'000;
  for (int64_t out = 0; out <= 100; out += 5) {
    ClockOffset clock;
    const int64_t sent = 1'700'000'000'000'000'000, received = sent + out + kAhead;
    clock.add(sent, received, received + 40, sent + 140);
    EXPECT_LE(std::abs(clock.estimate()->offset - kAhead), clock.estimate()->error) << out;
    EXPECT_EQ(clock.estimate()->error, 50);
  }
}

TEST(ClockOffset, IsThatOfTheMostExactRecentRequest) {
  ClockOffset clock;
  clock.add(0, 50, 50, 10);  // 45 within 5
  for (int i = 0; i < 63; ++i) clock.add(0, 100, 100, 40);
  EXPECT_EQ(clock.estimate()->error, 5);
  clock.add(0, 100, 100, 40);  // the exact one is forgotten
  EXPECT_EQ(clock.estimate()->offset, 80);
  EXPECT_EQ(clock.estimate()->error, 20);
}

TEST(ClockOffset, LeavesOutStampsThatCannotBe) {
  ClockOffset clock;
  clock.add(100, 1000, 2000, 200);  // 1000 in the server, within a round trip of 100
  EXPECT_FALSE(clock.estimate());
  constexpr int64_t kMax = (int64_t{1} << 62) - 1;
  clock.add(0, 0, 0, kMax);
  clock.add(kMax, 0, kMax, 0);
  clock.add(0, kMax, kMax, 0);
  ASSERT_TRUE(clock.estimate());
  EXPECT_EQ(clock.estimate()->offset, kMax);
}

TEST(ServerTimes, ComeAsTheServerSendsThem) {
  const ServerTimes sent{1'700'000'000'000'000'000, 1'700'000'000'000'005'000, 0, 3};
  const std::string text = text_of(encode_infer_response({"m", ""}, "", {}, &sent));
  const auto response = parse_infer_response(chunks_of(text));
  ASSERT_TRUE(response && response->times);
  EXPECT_EQ(response->times->received_ns, sent.received_ns);
  EXPECT_EQ(response->times->answered_ns, sent.answered_ns);
  EXPECT_EQ(response->times->queue_us, 0);
  EXPECT_EQ(response->times->compute_us, 3);
}

TEST(ServerTimes, AreNoneWhenTheyCannotBe) {
  constexpr int64_t kHuge = std::numeric_limits<int64_t>::max();
  for (const ServerTimes& sent :
       {ServerTimes{2, 1, 0, 0}, ServerTimes{-1, 1, 0, 0}, ServerTimes{0, kHuge, 0, 0},
        ServerTimes{0, 0, kHuge, 0}, ServerTimes{0, 0, 0, -1}}) {
    const std::string text = text_of(encode_infer_response({"m", ""}, "", {}, &sent));
    const auto response = parse_infer_response(chunks_of(text));
    ASSERT_TRUE(response);
    EXPECT_FALSE(response->times);
  }
  const std::string without = text_of(encode_infer_response({"m", ""}, "", {}, nullptr));
  EXPECT_FALSE(parse_infer_response(chunks_of(without))->times);
  EXPECT_FALSE(parse_infer_response(chunks_of(std::string("\x22\x02\x0a\x05", 4))));  // cut off
}

TEST(ServerTimes, AreAskedForByAParameter) {
  uint64_t copied = 0;
  for (const bool wants : {false, true}) {
    const auto pieces = encode_infer_request("m", "", {}, Contents::Raw, wants, &copied);
    ASSERT_TRUE(pieces);
    const std::string text = text_of(*pieces);
    EXPECT_EQ(parse_infer_request(chunks_of(text))->wants_times, wants);
  }
}

TEST(Extensions, AreFoundByTheWholeName) {
  const std::array<std::string_view, 2> some{"weir_times_2", "statistics"},
      all{"weir_times", "statistics"};
  const std::string without = text_of(encode_server_metadata("a", "weir_times", some));
  const std::string with = text_of(encode_server_metadata("a", "1", all));
  EXPECT_FALSE(*parse_has_extension(chunks_of(without), kTimesExtension));
  EXPECT_TRUE(*parse_has_extension(chunks_of(with), kTimesExtension));
  EXPECT_FALSE(parse_has_extension(chunks_of(with.substr(0, with.size() - 1)), kTimesExtension));
}

}  // namespace link_statistics_test
}  // namespace weir::net
