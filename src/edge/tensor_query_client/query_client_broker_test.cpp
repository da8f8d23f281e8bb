// tensor_query_client with connect-type=HYBRID: servers that an MQTT broker announces.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/tensor_query_client/query_client_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "transport/mqtt/broker_test_support.hpp"
#include "transport/mqtt/server_discovery.hpp"

namespace query_client_broker_test {

using namespace std::chrono_literals;
using namespace weir::test;
using weir::transport::ServerAnnouncement;

class QueryClientBroker : public BrokerTest {
 protected:
  std::string client(const std::string& more = "timeout=60000") const {
    return "tensor_query_client port=0 connect-type=HYBRID dest-host=127.0.0.1 dest-port=" +
           broker_.port_text() + " topic=objects " + more;
  }
  std::unique_ptr<ServerAnnouncement> announce(uint16_t port, const std::string& id,
                                               const std::string& host = "127.0.0.1") const {
    weir::transport::BrokerOptions options;
    options.port = broker_.port();
    auto out = ServerAnnouncement::open(options, id, "objects", {host, port});
    EXPECT_TRUE(out) << (out ? "" : out.error().message());
    return out ? *std::move(out) : nullptr;
  }
  // A server that adds its number to each byte.
  static ScriptedServer::Script adds(uint8_t number) {
    return [number](ScriptedServer& s) {
      const auto serve_one = [&s, number] {
        s.handshake(four_bytes(), four_bytes());
        for (;;) {
          const auto message = s.read();
          if (message.command == weir::wire::Command::Error) return;
          auto bytes = weir::wire::test::copy_of(message.memories.at(0).bytes());
          for (auto& byte : bytes)
            byte = static_cast<std::byte>(std::to_integer<int>(byte) + number);
          s.respond({bytes});
        }
      };
      for (;;) s.until_closed(serve_one);
    };
  }
  // The first byte of the response to a frame of zeros; -1 without one.
  static int ask(const Harness& h) {
    EXPECT_EQ(gst_harness_push(h.get(), frame(four(0))), GST_FLOW_OK);
    const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
    return got ? content(got.get()).at(0) : -1;
  }
  // Its only server has gone, with the response to one frame.
  Harness client_that_lost_its_server() const {
    const ScriptedServer server([](ScriptedServer& s) {
      s.handshake(four_bytes(), four_bytes());
      s.read();
      s.close();
    });
    const auto announcement = announce(server.port(), "1");
    auto out = make_harness(client(), four_bytes());
    EXPECT_EQ(ask(out), -1);
    return out;
  }
  static bool responses_become(const Harness& h, int value) {
    return becomes_true([&] { return ask(h) == value; }, "an answer of the other server");
  }

  TestBroker broker_;
};

TEST_F(QueryClientBroker, FindsTheServer) {
  const ScriptedServer server(adds(1));
  const auto announcement = announce(server.port(), "1");
  const auto h = make_harness(client(), four_bytes());
  EXPECT_EQ(ask(h), 1);
  EXPECT_EQ(client_stat(h, "answered"), 1u);
}

// A pipeline that adds `number` to each byte and announces itself.
std::string serving(const TestBroker& broker, int number) {
  return "tensor_query_serversrc host=127.0.0.1 port=0 connect-type=HYBRID topic=objects "
         "dest-host=127.0.0.1 dest-port=" +
         broker.port_text() + " ! " + four_bytes() +
         " ! tensor_transform mode=arithmetic option=add:" + std::to_string(number) +
         " ! tensor_query_serversink";
}

TEST_F(QueryClientBroker, FindsAPipelineThatServes) {
  PlayedPipeline server(serving(broker_, 3));
  gst_element_set_state(server.get(), GST_STATE_PLAYING);
  const auto h = make_harness(client(), four_bytes());
  EXPECT_EQ(ask(h), 3);
}

TEST_F(QueryClientBroker, APipelineThatPausesIsNotFound) {
  PlayedPipeline server(serving(broker_, 3));
  gst_element_set_state(server.get(), GST_STATE_PLAYING);
  {
    const auto h = make_harness(client(), four_bytes());
    EXPECT_EQ(ask(h), 3);
  }
  gst_element_set_state(server.get(), GST_STATE_PAUSED);
  const ScriptedServer other(adds(1));
  const auto announcement = announce(other.port(), "1");
  const auto h = make_harness(client(), four_bytes());
  EXPECT_EQ(ask(h), 1);
}

TEST_F(QueryClientBroker, AServerNeedsItsBroker) {
  const std::string port = std::to_string(free_port());
  const std::string error = error_of_pipeline(
      "tensor_query_serversrc port=0 connect-type=HYBRID topic=a dest-host=127.0.0.1 dest-port=" +
      port + " ! " + four_bytes() + " ! tensor_query_serversink");
  EXPECT_SAYS(error, "WEIR-6005");
  EXPECT_SAYS(error, "127.0.0.1:" + port);
}

TEST_F(QueryClientBroker, WaitsForAServerThatComesLater) {
  const ScriptedServer server(adds(1));
  Harness h{gst_harness_new_parse(client().c_str())};
  gst_harness_play(h.get());
  std::thread streams([&] {
    gst_harness_set_src_caps_str(h.get(), four_bytes().c_str());
    EXPECT_EQ(ask(h), 1);
  });
  const auto announcement = announce(server.port(), "1");
  streams.join();
}

TEST_F(QueryClientBroker, TheAddressOfADeadServerDoesNotHang) {
  const auto dead = announce(free_port(), "1");
  const ScriptedServer server(adds(2));
  const auto announcement = announce(server.port(), "2");
  const auto h = make_harness(client(), four_bytes());
  EXPECT_EQ(ask(h), 2);
}

// It accepts connections and sends nothing.
TEST_F(QueryClientBroker, ASilentServerDoesNotHang) {
  const ScriptedServer silent([](auto& s) { s.wait_for_the_end_of_the_test(); });
  const auto first = announce(silent.port(), "1");
  const ScriptedServer server(adds(2));
  const auto second = announce(server.port(), "2");
  const auto h = make_harness(client(), four_bytes());
  Errors errors(h);
  EXPECT_EQ(ask(h), 2);
}

// Everyone who may use the broker can announce an address.
TEST_F(QueryClientBroker, AServerThatAllowDoesNotNameIsLeftOut) {
  const auto other = announce(1, "1", "192.0.2.77");
  const Harness h{gst_harness_new_parse(client("timeout=60000 allow=127.0.0.1").c_str())};
  Errors errors(h);
  gst_harness_play(h.get());
  std::thread streams([&] {
    gst_harness_set_src_caps_str(h.get(), four_bytes().c_str());
    EXPECT_EQ(ask(h), 2);
  });
  std::string warning;
  EXPECT_TRUE(
      becomes_true([&] { return !(warning = errors.next_warning()).empty(); }, "a warning"));
  EXPECT_SAYS(warning, "the property allow does not name the server");
  EXPECT_SAYS(warning, "offered: connecting to 192.0.2.77:1 with allow=127.0.0.1");
  const ScriptedServer server(adds(2));
  const auto announcement = announce(server.port(), "2");
  streams.join();
}

TEST_F(QueryClientBroker, ALostServerIsReplacedByAnother) {
  ScriptedServer first([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.read();
    s.respond({weir::wire::test::Bytes(4, std::byte{1})});
    s.read();
    s.close();
  });
  const auto first_announcement = announce(first.port(), "1");
  const ScriptedServer second(adds(2));
  const auto second_announcement = announce(second.port(), "2");
  const auto h = make_harness(client(), four_bytes());
  Errors errors(h);
  EXPECT_EQ(ask(h), 1);
  EXPECT_EQ(ask(h), -1);
  EXPECT_SAYS(errors.next_warning(), "127.0.0.1:" + std::to_string(first.port()));
  EXPECT_TRUE(responses_become(h, 2));  // its address may come later than the first one
  EXPECT_EQ(client_stat(h, "lost"), 1u);
  EXPECT_EQ(client_stat(h, "reconnections"), 1u);
  EXPECT_EQ(errors.next(), "");
}

TEST_F(QueryClientBroker, WithoutAnotherServerFramesAreDroppedUntilOneComes) {
  const auto h = client_that_lost_its_server();
  EXPECT_EQ(ask(h), -1);
  EXPECT_EQ(client_stat(h, "dropped-lost"), 2u);
  const ScriptedServer second(adds(2));
  const auto second_announcement = announce(second.port(), "2");
  EXPECT_TRUE(responses_become(h, 2));
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

// Each attempt takes the second after which the other one may be tried again.
TEST_F(QueryClientBroker, TwoSilentServersDoNotHoldTheStreamThatLostItsOwn) {
  const auto h = client_that_lost_its_server();
  const ScriptedServer one([](auto& s) { s.wait_for_the_end_of_the_test(); });
  const ScriptedServer other([](auto& s) { s.wait_for_the_end_of_the_test(); });
  const auto second = announce(one.port(), "2"), third = announce(other.port(), "3");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ask(h), -1);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  expect_sums(h);
}

TEST_F(QueryClientBroker, AServerThatDoesNotAnswerIsReplaced) {
  const ScriptedServer first([](auto& s) {
    s.handshake(four_bytes(), four_bytes());
    s.ignore_all();
  });
  const auto first_announcement = announce(first.port(), "1");
  const ScriptedServer second(adds(2));
  const auto second_announcement = announce(second.port(), "2");
  const auto h = make_harness(client("timeout=20"), four_bytes());
  EXPECT_TRUE(responses_become(h, 2));
  EXPECT_GE(client_stat(h, "late"), 3u);
}

TEST_F(QueryClientBroker, AServerThatTakesOtherFramesIsNamed) {
  const ScriptedServer server([](auto& s) {
    s.accept();
    s.greet(tensors("float32", "10"), four_bytes());
    s.ignore_all();
  });
  const auto announcement = announce(server.port(), "1");
  const std::string error = start_error(client(), four_bytes());
  EXPECT_SAYS(error, "the query server does not accept this stream");
  EXPECT_SAYS(error, "float32");
}

TEST_F(QueryClientBroker, AServerThatTakesOtherFramesIsNotTheOnlyOne) {
  const ScriptedServer other([](auto& s) {
    s.accept();
    s.greet(tensors("float32", "10"), four_bytes());
    s.ignore_all();
  });
  const auto first = announce(other.port(), "1");
  const ScriptedServer server(adds(2));
  const auto second = announce(server.port(), "2");
  const auto h = make_harness(client(), four_bytes());
  EXPECT_EQ(ask(h), 2);
}

TEST_F(QueryClientBroker, StopsWhileItWaits) {
  const auto element = lone_element(client());
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  ASSERT_EQ(gst_element_set_state(element.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_SUCCESS);
  std::thread streams([&] {
    gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(four_bytes().c_str()));
    gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get()));
  });
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_NULL), GST_STATE_CHANGE_SUCCESS);
  streams.join();
}

TEST_F(QueryClientBroker, ABrokerThatIsNotThereIsNamed) {
  const std::string port = std::to_string(free_port());
  const std::string error = start_error(
      "tensor_query_client connect-type=HYBRID topic=objects dest-host=127.0.0.1 dest-port=" +
      port);
  EXPECT_SAYS(error, "127.0.0.1:" + port);
  EXPECT_SAYS(error, "dest-host and dest-port");
}

TEST_F(QueryClientBroker, TopicsThatCannotBeUsedAreNamed) {
  EXPECT_SAYS(start_error("tensor_query_client connect-type=HYBRID dest-host=127.0.0.1 dest-port=" +
                          broker_.port_text()),
              "topic");
  EXPECT_SAYS(start_error("tensor_query_client connect-type=HYBRID topic=a/# dest-host=127.0.0.1 "
                          "dest-port=" +
                          broker_.port_text()),
              "a/#");
  EXPECT_SAYS(start_error("tensor_query_client connect-type=HYBRID topic=a dest-port=0"),
              "dest-port=0");
}

}  // namespace query_client_broker_test
