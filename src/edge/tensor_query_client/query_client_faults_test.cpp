// tensor_query_client with servers that are late, silent, broken or gone, and stops at every point.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/tensor_query_client/query_client_test_support.hpp"

namespace query_client_faults_test {

using namespace weir::test;
using weir::wire::test::from_text;

TEST(QueryClientFaults, ALostResponseFreesItsPlaceAndTheNextConnectionStartsClean) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.ignore_all();
    handshake_and_echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=20 max-request=1"), four_bytes());
  Errors errors(h);
  uint8_t sent = 0;
  while (gst_harness_buffers_received(h.get()) < 2 && sent < 100) {
    ASSERT_EQ(push(h, sent++), GST_FLOW_OK);
    if (client_stat(h, "late") >= 3)  // the server answers from now on, perhaps slowly
      g_object_set(find_element(h, kClient).get(), "timeout", 60000, nullptr);
  }
  for (int i = 0; i < 2; ++i) {
    const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
    ASSERT_TRUE(got);
    EXPECT_EQ(GST_BUFFER_PTS(got.get()), content(got.get())[0] * GST_SECOND);
  }
  EXPECT_GE(client_stat(h, "late"), 3u);
  EXPECT_EQ(client_stat(h, "dropped-policy"), 0u);
  EXPECT_SAYS(errors.next_warning(), "timeout=20 ms");
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(client_stat(h, "reconnections"), 1u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

// A server that drops one frame of three, and repeats no numbers: no response goes to a frame that
// did not ask for it.
TEST(QueryClientFaults, ResponsesBelongToTheirFramesWhenTheServerDropsSome) {
  ScriptedServer server([](auto& s) {
    const auto serve_one = [&s] {
      s.handshake(four_bytes(), four_bytes());
      for (int i = 1;; ++i) {
        const auto message = s.read();
        if (message.command == weir::wire::Command::Error) return;
        if (i % 3 != 0) s.echo(message);
      }
    };
    for (;;) s.until_closed(serve_one);
  });
  const auto h = make_harness(client_of(server, "timeout=20"), four_bytes());
  const auto enough = [&](uint8_t sent) {
    return sent >= 40 && gst_harness_buffers_received(h.get()) >= 5;
  };
  for (uint8_t i = 0; i < 250 && !enough(i); ++i) ASSERT_EQ(push(h, i), GST_FLOW_OK);
  const guint responses = gst_harness_buffers_received(h.get());
  EXPECT_GE(responses, 5u);
  for (guint i = 0; i < responses; ++i) {
    const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(got.get()), content(got.get())[0] * GST_SECOND);
  }
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

TEST(QueryClientFaults, ALateResponseIsPushedBeforeTheNextFrame) {
  weir::transport::WakeEvent may_respond;
  std::atomic<bool> answered{false};
  ScriptedServer server([&](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    const auto message = s.read();
    s.wait(may_respond.descriptor(), POLLIN);
    s.echo(message);
    answered = true;
    echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=10"), four_bytes());
  push(h, 1);
  EXPECT_EQ(client_stat(h, "late"), 1u);
  EXPECT_EQ(gst_harness_buffers_received(h.get()), 0u);
  may_respond.set();
  ASSERT_TRUE(becomes_true([&] { return answered.load(); }, "the answer"));
  g_object_set(find_element(h, kClient).get(), "timeout", 60000, nullptr);
  push(h, 2);
  expect_response(h, 1);
  expect_response(h, 2);
  EXPECT_EQ(client_stat(h, "late"), 1u);
  EXPECT_EQ(client_stat(h, "answered"), 1u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

// The end of the server.

class QueryClientWithoutServer : public ::testing::TestWithParam<bool> {};

TEST_P(QueryClientWithoutServer, PostsAnError) {
  const bool says_so = GetParam();
  ScriptedServer server([&](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.read();
    if (says_so) s.send(s.requests, weir::wire::test::golden_error());
    s.close();
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  Errors errors(h);
  EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, says_so ? "the query server has ended the connection"
                             : "the connection to the query server was lost");
  EXPECT_SAYS(error, "localhost:" + std::to_string(server.port()));
  EXPECT_SAYS(error, "reconnect=true");
  EXPECT_EQ(client_stat(h, says_so ? "refused" : "lost"), 1u);
  expect_sums(h);
}

TEST_P(QueryClientWithoutServer, WithReconnectGoesToTheNextOne) {
  const bool says_so = GetParam();
  ScriptedServer server([&](auto& s) {
    for (int i = 0; i < 3; ++i) {
      s.handshake(four_bytes(), four_bytes());
      s.echo(s.read());
      s.read();
      if (says_so) s.send(s.responses, weir::wire::test::golden_error());
      s.close();
    }
    handshake_and_echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000 reconnect=true"), four_bytes());
  Errors errors(h);
  for (uint8_t i = 0; i < 8; ++i) ASSERT_EQ(push(h, i), GST_FLOW_OK);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "fix: tensor_query_serversrc port=" + std::to_string(server.port()));
  EXPECT_EQ(warning.find("reconnect=true"), std::string::npos) << warning;
  for (const uint8_t i : {0, 2, 4, 6, 7}) expect_response(h, i);
  EXPECT_EQ(client_stat(h, "reconnections"), 3u);
  EXPECT_EQ(client_stat(h, says_so ? "refused" : "lost"), 3u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

INSTANTIATE_TEST_SUITE_P(QueryClientFaults, QueryClientWithoutServer, ::testing::Bool(),
                         [](const auto& says_so) {
                           return says_so.param ? "ThatSendsError" : "ThatIsKilled";
                         });

TEST(QueryClientFaults, AServerThatIsNotThereIsNamed) {
  uint16_t port = 0;
  {
    const ScriptedServer server([](auto&) {});
    port = server.port();
  }
  const std::string error =
      start_error("tensor_query_client port=0 dest-port=" + std::to_string(port), four_bytes());
  EXPECT_SAYS(error, "the query server cannot be reached");
  EXPECT_SAYS(error, "localhost:" + std::to_string(port));
  EXPECT_SAYS(error, "in a pipeline that is playing");
  EXPECT_SAYS(error, "reconnect=true, which waits for the tensor_query_serversrc");
}

TEST(QueryClientFaults, WithReconnectItWaitsForAServerThatComesLater) {
  uint16_t port = 0;
  {
    const ScriptedServer server([](auto&) {});
    port = server.port();
  }
  const auto h = make_harness(
      "tensor_query_client port=0 reconnect=true timeout=60000 dest-host=tcp://localhost:" +
          std::to_string(port),
      four_bytes());
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  EXPECT_EQ(client_stat(h, "dropped-lost"), 1u);
  EXPECT_EQ(client_stat(h, "sent"), 0u);
  const ScriptedServer server([](auto& s) { handshake_and_echo_all(s); }, port);
  ASSERT_TRUE(becomes_true(
      [&] {
        push(h, 2);
        return gst_harness_buffers_received(h.get()) > 0;
      },
      "an answer"));
  expect_response(h, 2);
}

// docs/compatibility/edge-wire.md 10.6, class 9.

class ResponsesUnlikeTheirCaps : public ::testing::Test {
 protected:
  static std::string error(const std::string& caps,
                           const std::vector<weir::wire::test::Bytes>& memories) {
    ScriptedServer server([&](auto& s) {
      s.handshake(four_bytes(), caps);
      s.read();
      s.respond(memories);
      s.ignore_all();
    });
    const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
    Errors errors(h);
    EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
    expect_sums(h);
    return errors.next();
  }
};

TEST_F(ResponsesUnlikeTheirCaps, InTheirSizeAreAnError) {
  const std::string text = error(four_bytes(), {from_text("abc")});
  EXPECT_SAYS(text, "an answer does not fit the caps that the server announced");
  EXPECT_SAYS(text, "3");
}
TEST_F(ResponsesUnlikeTheirCaps, InTheirNumberAreAnError) {
  EXPECT_SAYS(error(four_bytes(), {from_text("abcd"), from_text("abcd")}), "does not fit");
  EXPECT_SAYS(error(tensors("uint8,uint8", "4,4"), {from_text("abcd")}), "does not fit");
}
TEST_F(ResponsesUnlikeTheirCaps, InTheirHeadersAreAnError) {
  const std::string flexible = "other/tensors,format=(string)flexible,framerate=30/1";
  EXPECT_SAYS(error(flexible, {from_text("abcd")}), "does not fit");
  EXPECT_SAYS(error(flexible, {weir::wire::test::Bytes(132, std::byte{0xff})}), "does not fit");
}
TEST_F(ResponsesUnlikeTheirCaps, BeyondMaxMessageAreAnError) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.read();
    s.respond({weir::wire::test::Bytes(2000)});
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server, "timeout=60000 max-message=1024"), four_bytes());
  Errors errors(h);
  EXPECT_EQ(push(h, 1), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "larger than allowed");
}

TEST(QueryClientFaults, AFrameWithMoreMemoriesThanTheServerTakesIsAnError) {
  const std::string any = "application/octet-stream";
  ScriptedServer server([&](auto& s) {
    s.handshake(any, any, HeaderForm::Bytes168);
    s.ignore_all();
  });
  const auto h = make_harness(client_of(server), any);
  Errors errors(h);
  GstBuffer* buffer = gst_buffer_new();
  for (int i = 0; i < 16; ++i)
    gst_buffer_append_memory(buffer, gst_allocator_alloc(nullptr, 1, nullptr));
  EXPECT_EQ(gst_harness_push(h.get(), buffer), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "16 memories");
  EXPECT_SAYS(error, "at most 15");
  EXPECT_EQ(client_stat(h, "sent"), 0u);
  expect_sums(h);
}

// Class 10: stops and flushes.

TEST(QueryClientFaults, AFlushForgetsWhatWasAsked) {
  ScriptedServer server([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.ignore_all();
    handshake_and_echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000"), four_bytes());
  std::thread waits([&] { EXPECT_EQ(push(h, 1), GST_FLOW_FLUSHING); });
  ASSERT_TRUE(wait_for_stat(h, kClient, "sent", 1));
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  waits.join();
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(client_stat(h, "lost"), 1u);
  expect_sums(h);
  ASSERT_EQ(push(h, 2), GST_FLOW_OK);
  expect_response(h, 2);
}

// The order of the request and the flush is relaxed: the thread that flushes must read nothing that
// the streaming thread wrote.
TEST(QueryClientFaults, AFlushMayComeAfterTheConnectionOfAFrame) {
  uint16_t port = 0;
  {
    const ScriptedServer absent([](auto&) {});
    port = absent.port();
  }
  const auto h = make_harness(
      "tensor_query_client port=0 reconnect=true timeout=60000 dest-port=" + std::to_string(port),
      four_bytes());
  std::atomic<bool> asked{false};
  ScriptedServer server(
      [&](auto& s) {
        s.handshake(four_bytes(), four_bytes());
        s.read();
        asked.store(true, std::memory_order_relaxed);
        s.ignore_all();
      },
      port);
  std::thread streams([&] {
    while (push(h, 1) == GST_FLOW_OK) {
    }
  });
  EXPECT_TRUE(becomes_true([&] { return asked.load(std::memory_order_relaxed); }, "a request"));
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  streams.join();
  EXPECT_EQ(client_stat(h, "sent"), 1u);
}

class QueryClientStops : public ::testing::TestWithParam<int> {};

// The server stops after this many steps of the handshake.
TEST_P(QueryClientStops, Anywhere) {
  const int steps = GetParam();
  weir::transport::WakeEvent reached;
  ScriptedServer server([&](auto& s) {
    if (steps > 0) s.accept();
    if (steps > 1) s.greet(four_bytes(), four_bytes());
    if (steps > 2) s.connect_back();
    if (steps > 3) s.read();
    reached.set();
    s.wait_for_the_end_of_the_test();
  });
  const auto element = lone_element(client_of(server, "timeout=60000"));
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_element_set_state(element.get(), GST_STATE_PLAYING);
  std::thread streams([&] {
    gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(four_bytes().c_str()));
    gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get()));
    gst_pad_send_event(pad.get(), time_segment());
    gst_pad_chain(pad.get(), frame(four(1)));
  });
  pollfd watched{reached.descriptor(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 60'000), 1);
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
  streams.join();
}
INSTANTIATE_TEST_SUITE_P(QueryClientFaults, QueryClientStops, ::testing::Range(0, 5));

// A live source pauses only when its caps have been taken.
TEST(QueryClientFaults, APauseEndsTheHandshakeAndTheNextFrameBeginsAnother) {
  weir::transport::WakeEvent reached;
  ScriptedServer server([&](auto& s) {
    s.until_closed([&] {
      s.accept();
      reached.set();
      s.read();
    });
    handshake_and_echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000"));
  Errors errors(h);
  const auto element = find_element(h, kClient);
  std::thread streams([&] {
    gst_harness_push_event(h.get(), gst_event_new_stream_start("test"));
    gst_harness_set_src_caps_str(h.get(), four_bytes().c_str());
  });
  pollfd watched{reached.descriptor(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 60'000), 1);
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  streams.join();
  EXPECT_EQ(errors.next(), "");
  gst_element_set_state(element.get(), GST_STATE_PLAYING);
  ASSERT_EQ(push(h, 1), GST_FLOW_OK);
  expect_response(h, 1);
}

TEST(QueryClientFaults, ItCanStartAgainAfterEachStop) {
  ScriptedServer server([](auto& s) {
    for (;;) handshake_and_echo_all(s);
  });
  const auto h = make_harness(client_of(server, "timeout=60000"));
  const auto element = find_element(h, kClient);
  for (uint8_t i = 0; i < 10; ++i) {
    gst_element_set_state(element.get(), GST_STATE_PLAYING);
    gst_harness_push_event(h.get(), gst_event_new_stream_start("test"));
    gst_harness_set_src_caps_str(h.get(), four_bytes().c_str());
    ASSERT_EQ(push(h, i), GST_FLOW_OK) << int{i};
    expect_response(h, i);
    EXPECT_EQ(client_stat(h, "sent"), 1u);
    gst_element_set_state(element.get(), GST_STATE_NULL);
  }
}

}  // namespace query_client_faults_test
