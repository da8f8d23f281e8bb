// tensor_query_client with servers that answer: bytes, times, caps, places, outcomes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include "edge/tensor_query_client/query_client_test_support.hpp"

namespace tensor_query_client_test {

using namespace weir::test;

TEST(TensorQueryClient, ResponsesHaveTheBytesAndTimesOfTheirFramesInEachForm) {
  for (const auto form : {HeaderForm::Bytes2088, HeaderForm::Bytes168, HeaderForm::Bytes160}) {
    ScriptedServer server([form](auto& s) { handshake_and_echo_all(s, form); });
    const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
    for (uint8_t i = 0; i < 5; ++i) {
      ASSERT_EQ(push(h, i), GST_FLOW_OK);
      expect_response(h, i);
    }
    EXPECT_EQ(client_stat(h, "sent"), 5u);
    EXPECT_EQ(client_stat(h, "answered"), 5u);
    EXPECT_EQ(client_stat(h, "bytes-copied"), 0u);
  }
}

TEST(TensorQueryClient, MoreThan16TensorsTravelAsAMemoryEach) {
  std::string types = "uint8", dimensions = "1";
  for (int i = 1; i < 20; ++i) types += ",uint8", dimensions += ",1";
  const std::string caps = tensors(types, dimensions);
  std::atomic<size_t> memories{0};
  ScriptedServer server([&](auto& s) {
    s.handshake(caps, caps);
    const auto message = s.read();
    memories = message.memories.size();
    s.echo(message);
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), caps);
  ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(20))), GST_FLOW_OK);
  EXPECT_EQ(memories, 20u);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(got);
  EXPECT_EQ(gst_buffer_n_memory(got.get()), 16u);
}

TEST(TensorQueryClient, WithoutTimeoutResponsesComeWithLaterFrames) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    const auto a = s.read(), b = s.read();
    s.echo(a);
    s.echo(b);
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server, "max-request=1"), four_bytes());
  push(h, 1);
  push(h, 2);
  // Frames that find no room bring the responses.
  ASSERT_TRUE(becomes_true(
      [&] {
        push(h, 3);
        return gst_harness_buffers_received(h.get()) >= 2;
      },
      "two answers"));
  expect_response(h, 1);
  expect_response(h, 2);
}

TEST(TensorQueryClient, MoreThanMaxRequestFramesAreDropped) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server, "max-request=2"), four_bytes());
  Errors errors(h);
  for (uint8_t i = 0; i < 10; ++i) ASSERT_EQ(push(h, i), GST_FLOW_OK);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "the query server does not answer in time: frames are dropped");
  EXPECT_SAYS(warning,
              "localhost:" + std::to_string(server.port()) + ", frames that wait for an answer: 3");
  EXPECT_SAYS(warning, "max-request is 2");
  EXPECT_EQ(errors.next_warning(), "") << "one for each outage";
  EXPECT_EQ(client_stat(h, "sent"), 3u);
  EXPECT_EQ(client_stat(h, "dropped-policy"), 7u);
  g_object_set(find_element(h, kClient).get(), "max-request", 0, nullptr);  // no limit
  for (uint8_t i = 0; i < 10; ++i) ASSERT_EQ(push(h, i), GST_FLOW_OK);
  EXPECT_EQ(client_stat(h, "sent"), 13u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(client_stat(h, "lost"), 13u);
  expect_sums(h);
}

// As servers of Weir do, with a pool of workers.
TEST(TensorQueryClient, ResponsesWithNumbersArePushedInTheOrderOfTheFrames) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    const auto a = s.read(), b = s.read(), c = s.read();
    s.echo(c, true);
    s.echo(a, true);
    s.echo(b, true);
    echo_all(s, true);
  });
  const auto h = make_harness(client_of(server), four_bytes());
  for (const uint8_t i : {1, 2, 3}) push(h, i);
  g_object_set(find_element(h, kClient).get(), "timeout", 60000, nullptr);
  ASSERT_TRUE(becomes_true(
      [&] {
        push(h, 4);
        return gst_harness_buffers_received(h.get()) >= 4;
      },
      "four answers"));
  for (const uint8_t i : {1, 2, 3, 4}) expect_response(h, i);
}

TEST(TensorQueryClient, EosWaitsForTheResponses) {
  weir::transport::WakeEvent may_respond;
  ScriptedServer server([&](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.echo(s.read());
    const auto late = s.read();
    s.wait(may_respond.descriptor(), POLLIN);
    s.echo(late);
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server), four_bytes());
  push(h, 1);
  push(h, 2);
  g_object_set(find_element(h, kClient).get(), "timeout", 60000, nullptr);
  std::thread ends([&] { gst_harness_push_event(h.get(), gst_event_new_eos()); });
  may_respond.set();
  ends.join();
  expect_response(h, 1);
  expect_response(h, 2);
  EXPECT_EQ(client_stat(h, "answered"), 2u);
  expect_sums(h);
}

TEST(TensorQueryClient, MetasOfTheFrameThatAskedStay) {
  ScriptedServer server([](auto& s) { handshake_and_echo_all(s); });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  GstBuffer* buffer = frame(four(1));
  gst_buffer_add_reference_timestamp_meta(
      buffer, Ref<GstCaps>::adopt(gst_caps_new_empty_simple("timestamp/x-test")).get(), 42,
      GST_CLOCK_TIME_NONE);
  gst_buffer_add_video_meta(buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 4, 1);
  GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
  gst_harness_push(h.get(), buffer);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(got);
  const auto* meta = gst_buffer_get_reference_timestamp_meta(got.get(), nullptr);
  ASSERT_TRUE(meta);
  EXPECT_EQ(meta->timestamp, 42u);
  EXPECT_TRUE(GST_BUFFER_FLAG_IS_SET(got.get(), GST_BUFFER_FLAG_DISCONT));
  // It describes memories that the response does not have.
  EXPECT_FALSE(gst_buffer_get_video_meta(got.get()));
}

TEST(TensorQueryClient, StatsHaveLatencies) {
  ScriptedServer server([](auto& s) { handshake_and_echo_all(s); });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  gint64 p50 = 0, p95 = 0, p99 = 0;
  const auto read = [&] {
    return gst_structure_get(stats(find_element(h, kClient).get()).get(), "p50-us", G_TYPE_INT64,
                             &p50, "p95-us", G_TYPE_INT64, &p95, "p99-us", G_TYPE_INT64, &p99,
                             nullptr);
  };
  EXPECT_FALSE(read());
  const gint64 began = g_get_monotonic_time();
  for (uint8_t i = 0; i < 20; ++i) push(h, i);
  ASSERT_TRUE(read());
  EXPECT_LE(p50, p95);
  EXPECT_LE(p95, p99);
  EXPECT_LE(p99, g_get_monotonic_time() - began);
}

// Caps.

TEST(TensorQueryClient, TheOutputHasTheCapsOfTheServer) {
  const std::string text = "text/x-raw,format=(string)utf8";
  ScriptedServer server([&](auto& s) {
    s.handshake(four_bytes(), text);
    s.read();
    s.respond({weir::wire::test::from_text("a cat")});
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  push(h, 1);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(got);
  EXPECT_EQ(content(got.get()), (Bytes{'a', ' ', 'c', 'a', 't'}));
  EXPECT_EQ(caps_text(h), "text/x-raw, format=(string)utf8");
}

TEST(TensorQueryClient, FrameRatesAndSpellingsOfCapsDoNotMatter) {
  for (const std::string& takes :
       {tensors("uint8", "4:1:1:1", "5/1"), tensors("uint8", "4", "0/1"),
        std::string("other/tensor,dimension=(string)4:1,type=(string)uint8,framerate=7/1"),
        std::string("other/tensors,format=static,num_tensors=1,types=(string)uint8,"
                    "dimensions=(string)4,framerate=[0/1,2147483647/1]")}) {
    ScriptedServer server([&](auto& s) {
      s.handshake(takes, four_bytes());
      echo_all(s);
    });
    const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
    EXPECT_EQ(push(h, 1), GST_FLOW_OK) << takes;
    expect_response(h, 1);
  }
}

TEST(TensorQueryClient, AnOpenFrameRateOfTheResponsesIsThatOfTheInput) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(),
                "other/tensors,format=(string)static,num_tensors=1,types=(string)uint8,"
                "dimensions=(string)4,framerate=[0/1,2147483647/1]");
    echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  push(h, 1);
  EXPECT_NE(caps_text(h).find("framerate=(fraction)30/1"), std::string::npos) << caps_text(h);
}

TEST(TensorQueryClient, NewCapsAreANewConnection) {
  const std::string two = tensors("uint8", "2");
  ScriptedServer server([&](auto& s) {
    handshake_and_echo_all(s);
    s.handshake(two, two);
    echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  push(h, 1);
  expect_response(h, 1);
  gst_harness_set_src_caps_str(h.get(), two.c_str());
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{7, 8})), GST_FLOW_OK);
  const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(got);
  EXPECT_EQ(content(got.get()), (Bytes{7, 8}));
  EXPECT_EQ(client_stat(h, "reconnections"), 1u);
}

class CapsOfAServer : public ::testing::Test {
 protected:
  static std::string error(const std::string& takes, const std::string& responses,
                           const std::string& downstream = "") {
    ScriptedServer server([&](auto& s) {
      s.accept();
      s.greet(takes, responses);
      s.ignore_all();
    });
    return start_error(client_of(server) + downstream, four_bytes());
  }
};

TEST_F(CapsOfAServer, ThatDoesNotTakeTheStreamAreNamed) {
  const std::string text = error(tensors("float32", "10"), four_bytes());
  EXPECT_SAYS(text, "the query server does not accept this stream");
  EXPECT_SAYS(text, "uint8");
  EXPECT_SAYS(text, "float32");
}
TEST_F(CapsOfAServer, ThatAreNoCapsAreNamed) {
  EXPECT_SAYS(error("no caps,", four_bytes()), "invalid caps for its input");
  EXPECT_SAYS(error(four_bytes(), "(((("), "invalid caps for its answers");
}
TEST_F(CapsOfAServer, ThatWouldOverflowTheStackAreRefused) {
  const std::string braces = "video/x-raw,a=" + std::string(60000, '{');
  for (const std::string& text : {error(braces, four_bytes()), error(four_bytes(), braces)}) {
    EXPECT_SAYS(text, "WEIR-6004: the query server announces invalid caps for its");
    EXPECT_SAYS(text, "at most 16 lists or structures in each other");
  }
}
TEST_F(CapsOfAServer, ThatFailAnAssertionAreRefused) {
  EXPECT_SAYS(error(four_bytes(), "1video/x-raw"), "a media type, which begins with a letter");
  EXPECT_SAYS(error("video/x-raw,rate=(fraction)[2/1,1/1]", four_bytes()), "the smaller one first");
}
TEST_F(CapsOfAServer, ThatAreSeveralForItsResponsesAreNamed) {
  EXPECT_SAYS(error(four_bytes(), "video/x-raw,width=[1,100]"), "several caps for its answers");
  EXPECT_SAYS(error(four_bytes(), "video/x-raw,width=[1,100]"), "put a capsfilter");
}

// Properties.

TEST(TensorQueryClient, OtherMachinesAreAWarning) {
  {
    const auto element = lone_element("tensor_query_client dest-host=192.0.2.1");
    Errors errors(element.get());
    gst_element_set_state(element.get(), GST_STATE_PAUSED);
    EXPECT_SAYS(errors.next_warning(), "not encrypted");
    gst_element_set_state(element.get(), GST_STATE_NULL);
  }
  const auto element = lone_element("tensor_query_client host=0.0.0.0");
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  EXPECT_SAYS(errors.next_warning(), "other machines can connect without encryption");
  gst_element_set_state(element.get(), GST_STATE_NULL);
  EXPECT_SAYS(start_error("tensor_query_client dest-host=192.0.2.1 allow=a/b/c"), "allow");
}

TEST(TensorQueryClient, ConnectsOnlyToServersThatAllowNames) {
  EXPECT_SAYS(start_error("tensor_query_client dest-host=192.0.2.1 allow=10.0.0.0/8"),
              "fix: allow=10.0.0.0/8,192.0.2.1");
  EXPECT_EQ(start_error("tensor_query_client dest-host=192.0.2.1 allow=192.0.2.0/24"), "");
}

TEST(TensorQueryClient, ABufferBeforeCapsIsAnError) {
  EXPECT_SAYS(error_before_caps("tensor_query_client"), "before caps");
}

}  // namespace tensor_query_client_test
