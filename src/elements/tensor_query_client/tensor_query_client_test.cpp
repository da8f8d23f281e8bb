// tensor_query_client with servers that answer in time, late or not at all.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/element_test_support.hpp"
#include "transport/edge/query_server_test_support.hpp"

namespace {

using namespace weir::test;
using weir::edge::test::ScriptedServer;
using weir::wire::HeaderForm;

constexpr char kFactory[] = "tensor_query_client";

std::string caps() {
  return tensors("uint8", "4");
}
std::string launch(const ScriptedServer& server, const std::string& options) {
  return std::string(kFactory) + " port=0 dest-port=" + std::to_string(server.port()) + " " +
         options;
}
void echo_all(ScriptedServer& server, HeaderForm form, bool repeats_numbers) {
  server.handshake(caps(), caps(), form);
  for (;;) {
    const auto message = server.read();
    if (message.command == weir::wire::Command::TransferData) server.echo(message, repeats_numbers);
  }
}
uint64_t outcomes(const Harness& h) {
  return stat(h, kFactory, "answered") + stat(h, kFactory, "late") + stat(h, kFactory, "refused") +
         stat(h, kFactory, "lost");
}
Bytes four(uint8_t value) {
  return Bytes(4, value);
}

TEST(TensorQueryClient, AnswersHaveTheBytesAndTimesOfTheirFramesInEachForm) {
  for (const auto form : {HeaderForm::Bytes2088, HeaderForm::Bytes168, HeaderForm::Bytes160}) {
    ScriptedServer server([form](auto& s) { echo_all(s, form, false); });
    const auto h = harness_of(launch(server, "timeout=60000"), caps());
    for (uint8_t i = 0; i < 5; ++i) {
      ASSERT_EQ(gst_harness_push(h.get(), frame(four(i), i * GST_SECOND, GST_MSECOND + i)),
                GST_FLOW_OK);
      const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
      ASSERT_TRUE(got);
      EXPECT_EQ(content(got.get()), four(i));
      EXPECT_EQ(GST_BUFFER_PTS(got.get()), i * GST_SECOND);
      EXPECT_EQ(GST_BUFFER_DURATION(got.get()), GST_MSECOND + i);
    }
    EXPECT_EQ(stat(h, kFactory, "sent"), 5u);
    EXPECT_EQ(stat(h, kFactory, "answered"), 5u);
  }
}

TEST(TensorQueryClient, WithoutTimeoutAnswersComeWithLaterFrames) {
  ScriptedServer server([](auto& s) {
    s.handshake(caps(), caps());
    const auto a = s.read(), b = s.read();
    s.echo(a);
    s.echo(b);
    s.ignore_all();
  });
  const auto h = harness_of(launch(server, "max-request=1"), caps());
  gst_harness_push(h.get(), frame(four(1), GST_SECOND));
  gst_harness_push(h.get(), frame(four(2), 2 * GST_SECOND));
  // Frames that find no room bring the answers.
  ASSERT_TRUE(becomes_true(
      [&] {
        gst_harness_push(h.get(), frame(four(3), 3 * GST_SECOND));
        return gst_harness_buffers_received(h.get()) >= 2;
      },
      "two answers"));
  for (uint8_t i = 1; i <= 2; ++i) {
    const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(content(got.get()), four(i));
    EXPECT_EQ(GST_BUFFER_PTS(got.get()), i * GST_SECOND);
  }
}

TEST(TensorQueryClient, MoreThanMaxRequestFramesAreDropped) {
  ScriptedServer server([](auto& s) {
    s.handshake(caps(), caps());
    s.ignore_all();
  });
  const auto h = harness_of(launch(server, "max-request=2"), caps());
  for (uint8_t i = 0; i < 10; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(four(i))), GST_FLOW_OK);
  EXPECT_EQ(stat(h, kFactory, "sent"), 3u);
  EXPECT_EQ(stat(h, kFactory, "dropped-policy"), 7u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(stat(h, kFactory, "lost"), 3u);
  EXPECT_EQ(outcomes(h), 3u);
}

TEST(TensorQueryClient, ALostAnswerFreesItsPlace) {
  ScriptedServer server([](auto& s) {
    s.handshake(caps(), caps());
    s.ignore_all();
    echo_all(s, HeaderForm::Bytes2088, false);
  });
  const auto h = harness_of(launch(server, "timeout=20 max-request=1"), caps());
  for (uint8_t i = 0; gst_harness_buffers_received(h.get()) < 2; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(four(i), i * GST_SECOND)), GST_FLOW_OK);
  for (int i = 0; i < 2; ++i) {
    const auto got = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    EXPECT_EQ(GST_BUFFER_PTS(got.get()), content(got.get())[0] * GST_SECOND);
  }
  EXPECT_GE(stat(h, kFactory, "late"), 3u);
  EXPECT_EQ(stat(h, kFactory, "reconnections"), 1u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(outcomes(h), stat(h, kFactory, "sent"));
}

TEST(TensorQueryClient, TheEndOfTheServerIsAnError) {
  ScriptedServer server([](auto& s) {
    s.handshake(caps(), caps());
    s.read();
    s.close();
  });
  const auto h = harness_of(launch(server, "timeout=60000"), caps());
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(four(1))), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "the connection with the query server broke");
  EXPECT_SAYS(error, "localhost:" + std::to_string(server.port()));
  EXPECT_SAYS(error, "reconnect=true");
  EXPECT_EQ(stat(h, kFactory, "lost"), 1u);
}

TEST(TensorQueryClient, CapsThatTheServerDoesNotTakeAreNamed) {
  ScriptedServer server([](auto& s) {
    s.accept();
    s.greet(tensors("float32", "10"), caps());
    s.ignore_all();
  });
  const std::string error = start_error(launch(server, ""), caps());
  EXPECT_SAYS(error, "the query server does not take this stream");
  EXPECT_SAYS(error, "uint8");
  EXPECT_SAYS(error, "float32");
}

TEST(TensorQueryClient, AServerThatIsNotThereIsNamed) {
  uint16_t port = 0;
  {
    const ScriptedServer server([](auto&) {});
    port = server.port();
  }
  const std::string error =
      start_error("tensor_query_client port=0 dest-port=" + std::to_string(port), caps());
  EXPECT_SAYS(error, "the query server cannot be reached");
  EXPECT_SAYS(error, "localhost:" + std::to_string(port));
}

TEST(TensorQueryClient, BrokersAreNotAvailable) {
  const std::string error = start_error("tensor_query_client connect-type=HYBRID");
  EXPECT_SAYS(error, "connect-type=HYBRID");
  EXPECT_SAYS(error, "connect-type=TCP");
}

TEST(TensorQueryClient, ABufferBeforeCapsIsAnError) {
  EXPECT_SAYS(error_before_caps("tensor_query_client"), "before caps");
}

}  // namespace
