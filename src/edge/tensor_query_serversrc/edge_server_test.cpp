// tensor_query_serversrc and tensor_query_serversink with NNStreamer's protocol, their default,
// and clients of raw sockets.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <functional>
#include <string>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/flushed_start_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "transport/edge/query_client_test_support.hpp"

namespace weir::test {
namespace edge_server_test {

using edge::test::RawClient;
using wire::HeaderForm;
using wire::test::from_text;
using wire::test::operator+;
using Message = std::vector<wire::test::Bytes>;

constexpr char kFour[] = "other/tensor,dimension=(string)4:1,type=(string)uint8,framerate=0/1";

Message numbers(std::initializer_list<int> values) {
  wire::test::Bytes out;
  for (const int value : values) out.push_back(static_cast<std::byte>(value));
  return {out};
}

class EdgeServer : public ::testing::Test {
 protected:
  void play(const std::string& rest, const std::string& options = "") {
    pipeline_ =
        std::make_unique<PlayedPipeline>("tensor_query_serversrc name=server port=0 " + options +
                                         " ! " + rest + " ! tensor_query_serversink name=end");
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PLAYING));
  }
  uint16_t port() const {
    guint port = 0;
    g_object_get(pipeline_->find("server").get(), "port", &port, nullptr);
    return static_cast<uint16_t>(port);
  }
  RawClient connected(HeaderForm form = HeaderForm::Bytes2088) const {
    RawClient out(port(), form);
    out.connect();
    return out;
  }
  Message exchange(RawClient* client, const Message& request) const {
    client->request(request);
    return client->response();
  }
  uint64_t stat(const char* name) const { return pipeline_->stat("server", name); }
  guint clients() const {
    guint out = 0;
    gst_structure_get_uint(stats(pipeline_->find("server").get()).get(), "clients", &out);
    return out;
  }
  bool clients_become(guint count) const {
    return becomes_true([&] { return clients() == count; }, std::to_string(count) + " clients");
  }
  void expect_sum(uint64_t received) const {
    EXPECT_EQ(stat("requests-received"), received);
    EXPECT_EQ(stat("requests-answered") + stat("requests-refused") + stat("requests-expired") +
                  stat("requests-aborted") + stat("requests-in-flight"),
              received);
  }

  std::unique_ptr<PlayedPipeline> pipeline_;
};

TEST_F(EdgeServer, ServesWithoutAProtocol) {
  play(std::string(kFour) + " ! tensor_transform mode=arithmetic option=add:1");
  RawClient client(port());
  const std::string caps =
      "other/tensor, dimension=(string)4:1, type=(string)uint8, framerate=(fraction)0/1";
  EXPECT_EQ(client.greeting(),
            "@query_server_src_caps@" + caps + "@query_server_sink_caps@" + caps);
  client.host_info();
  client.accept();
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(exchange(&client, numbers({i, 1, 2, 254})), numbers({i + 1, 2, 3, 255}));
  ASSERT_TRUE(
      becomes_true([&] { return stat("requests-answered") == 20; }, "20 answered requests"));
  expect_sum(20);
  EXPECT_EQ(stat("received"), 20u);
  EXPECT_EQ(stat("consumed"), 20u);
  EXPECT_EQ(stat("bytes-copied"), 0u);
  EXPECT_EQ(pipeline_->stat("end", "bytes-copied"), 0u);
}

TEST_F(EdgeServer, ServesClientsOfSeveralVersions) {
  play(kFour);
  auto newer = connected(), older = connected(HeaderForm::Bytes168);
  EXPECT_EQ(exchange(&older, numbers({1, 2, 3, 4})), numbers({1, 2, 3, 4}));
  EXPECT_EQ(exchange(&newer, numbers({5, 6, 7, 8})), numbers({5, 6, 7, 8}));
  play(kFour, "wire-version=0.2.2");
  auto oldest = connected(HeaderForm::Bytes160);
  EXPECT_EQ(exchange(&oldest, numbers({1, 2, 3, 4})), numbers({1, 2, 3, 4}));
}

TEST_F(EdgeServer, ServesOtherMedia) {
  play("application/octet-stream");
  auto client = connected();
  const Message parts{from_text("abc"), from_text("de")};
  EXPECT_EQ(exchange(&client, parts), parts);
}

std::string listed(const std::string& item, int count) {
  std::string out = item;
  for (int i = 1; i < count; ++i) out += "," + item;
  return out;
}

TEST_F(EdgeServer, MoreThan16TensorsAreAMemoryEach) {
  play(tensors(listed("uint8", 20), listed("1", 20)));
  auto client = connected();
  Message memories;
  for (int i = 0; i < 20; ++i) memories.push_back(numbers({i})[0]);
  EXPECT_EQ(exchange(&client, memories), memories);
}

constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=0/1";

// A tensor of uint8 whose header says that it has `count` elements.
wire::test::Bytes flexible(uint32_t count, const std::string& payload) {
  wire::test::Bytes out(kTensorHeaderBytes);
  write_tensor_header({.spec = {ElementType::UInt8, Shape{count}, ""}, .format = Format::Flexible},
                      std::span(out).first<kTensorHeaderBytes>());
  return std::move(out) + from_text(payload);
}

TEST_F(EdgeServer, FlexibleTensorsKeepTheirHeaders) {
  play(kFlexible);
  auto client = connected();
  for (const auto& request : {Message{flexible(3, "abc")}, {flexible(2, "de"), flexible(1, "f")}})
    EXPECT_EQ(exchange(&client, request), request);
}

// Keeps only the id of the client: elements that make buffers of their own may do that.
TEST_F(EdgeServer, TheIdOfTheClientIsEnough) {
  play(std::string(kFour) + " ! identity name=middle");
  const auto pad =
      Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline_->find("middle").get(), "src"));
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        auto* const old = GST_PAD_PROBE_INFO_BUFFER(info);
        GstBuffer* const made = gst_buffer_copy_deep(old);
        GstMeta* meta = nullptr;
        gpointer state = nullptr;
        const auto client = gst::get_client_id(old);
        std::vector<GstMeta*> metas;
        while ((meta = gst_buffer_iterate_meta(made, &state))) metas.push_back(meta);
        for (auto* one : metas) gst_buffer_remove_meta(made, one);
        if (client) gst::set_client(made, *client);
        gst_buffer_unref(old);
        GST_PAD_PROBE_INFO_DATA(info) = made;
        return GST_PAD_PROBE_OK;
      },
      nullptr, nullptr);
  auto one = connected(), two = connected();
  EXPECT_EQ(exchange(&one, numbers({1, 2, 3, 4})), numbers({1, 2, 3, 4}));
  EXPECT_EQ(exchange(&two, numbers({5, 6, 7, 8})), numbers({5, 6, 7, 8}));
}

TEST_F(EdgeServer, AClientThatLeavesWhileItsRequestIsInThePipelineIsCounted) {
  play(std::string(kFour) + " ! identity name=middle");
  auto leaver = connected(), other = connected();
  EXPECT_EQ(exchange(&other, numbers({1, 2, 3, 4})), numbers({1, 2, 3, 4}));
  ASSERT_TRUE(clients_become(2));
  std::function<void()> leave = [&] {
    leaver.close();
    EXPECT_TRUE(clients_become(1));
  };
  const auto pad =
      Ref<GstPad>::adopt(gst_element_get_static_pad(pipeline_->find("end").get(), "sink"));
  const gulong probe = gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo*, gpointer data) {
        (*static_cast<std::function<void()>*>(data))();
        return GST_PAD_PROBE_REMOVE;
      },
      &leave, nullptr);
  EXPECT_GT(probe, 0u);
  leaver.request(numbers({1, 2, 3, 4}));
  ASSERT_TRUE(becomes_true([&] { return stat("requests-expired") == 1; }, "an expired request"));
  EXPECT_EQ(exchange(&other, numbers({5, 6, 7, 8})), numbers({5, 6, 7, 8}));
  EXPECT_EQ(stat("answers-lost"), 1u);
  EXPECT_EQ(pipeline_->stat("end", "dropped-lost"), 1u);
  expect_sum(3);
}

TEST_F(EdgeServer, FramesThatThePipelineDropsAreCounted) {
  play(std::string(kFour) + " ! identity drop-probability=1");
  auto client = connected();
  client.request(numbers({1, 2, 3, 4}));
  ASSERT_TRUE(becomes_true([&] { return stat("requests-aborted") == 1; }, "a dropped request"));
  expect_sum(1);
}

// docs/compatibility/edge-wire.md 10.6, class 9: a client cannot end the pipeline.
class EdgeServerUnlikeItsCaps : public EdgeServer {
 protected:
  void expect_refused(const Message& request, const Message& good) {
    auto bad = connected();
    bad.request(request);
    bad.a.rest();
    bad.b.rest();
    EXPECT_EQ(stat("requests-refused"), 1u);
    EXPECT_EQ(stat("clients-refused"), 1u);
    auto client = connected();
    EXPECT_EQ(exchange(&client, good), good);
    ASSERT_TRUE(becomes_true([&] { return stat("requests-answered") == 1; }, "the answer"));
    expect_sum(2);
  }
};

TEST_F(EdgeServerUnlikeItsCaps, AnotherSize) {
  play(kFour);
  expect_refused(numbers({1, 2, 3}), numbers({1, 2, 3, 4}));
}
TEST_F(EdgeServerUnlikeItsCaps, FewerMemories) {
  play(tensors("uint8,uint8", "4,3"));
  expect_refused({Message{from_text("abcd")}}, {from_text("abcd"), from_text("efg")});
}
TEST_F(EdgeServerUnlikeItsCaps, MoreMemories) {
  play(kFour);
  expect_refused({from_text("abcd"), from_text("efg")}, {from_text("abcd")});
}
TEST_F(EdgeServerUnlikeItsCaps, AFlexibleHeaderThatLies) {
  play(kFlexible);
  expect_refused({flexible(5, "abcd")}, {flexible(4, "abcd")});
}
TEST_F(EdgeServerUnlikeItsCaps, AFlexibleTensorWithoutAHeader) {
  play(kFlexible);
  expect_refused({from_text("abcd")}, {flexible(4, "abcd")});
}
TEST_F(EdgeServerUnlikeItsCaps, SmallerVideo) {
  play("video/x-raw,format=GRAY8,width=4,height=2,framerate=0/1");
  expect_refused({from_text("abcdefg")}, {from_text("abcdefgh")});
}

TEST_F(EdgeServerUnlikeItsCaps, SeveralFramesOfVideo) {
  play("video/x-raw,format=GRAY8,width=4,height=2,framerate=0/1 ! tensor_converter");
  expect_refused({from_text("abcdefghabcdefgh")}, {from_text("abcdefgh")});
}
TEST_F(EdgeServerUnlikeItsCaps, PartsOfAudioSamples) {
  play("audio/x-raw,format=S16LE,channels=4,rate=16000,layout=interleaved ! tensor_converter");
  expect_refused({from_text("abc")}, {from_text("abcdefgh")});
}

TEST_F(EdgeServer, VideoMayHaveBytesAfterTheFrame) {
  play("video/x-raw,format=GRAY8,width=4,height=2,framerate=0/1 ! tensor_converter");
  auto client = connected();
  EXPECT_EQ(exchange(&client, {from_text("abcdefghijk")}), Message{from_text("abcdefgh")});
}

TEST_F(EdgeServer, TheResponseToTheLastFrameArrives) {
  play(kFour, "num-buffers=2");
  auto client = connected();
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(exchange(&client, numbers({i, 2, 3, 4})), numbers({i, 2, 3, 4}));
  EXPECT_EQ(pipeline_->outcome(), "");
  EXPECT_TRUE(pipeline_->reaches(GST_STATE_NULL));
  EXPECT_EQ(client.b.rest(), wire::test::golden_error());
}

TEST_F(EdgeServer, PausingClosesClientsAndPlayingServesAgain) {
  play(kFour);
  for (int i = 0; i < 3; ++i) {
    auto client = connected();
    EXPECT_EQ(exchange(&client, numbers({i, 2, 3, 4})), numbers({i, 2, 3, 4}));
    const guint was = port();
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PAUSED));
    client.a.rest();
    ASSERT_TRUE(pipeline_->reaches(i == 1 ? GST_STATE_NULL : GST_STATE_PAUSED));
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PLAYING));
    EXPECT_TRUE(i == 1 || port() == was);
  }
}

// Only the source stops, to change a property: the caps of the sink stay the same.
TEST_F(EdgeServer, ASourceThatStartsAgainServesWithTheSinkThatPlays) {
  const std::string four = kFour;
  for (const auto& rest : {four, four + " ! tensor_transform mode=arithmetic option=mul:1 ! queue",
                           video("GRAY8", 4, 1) + " ! tensor_converter"}) {
    play(rest);
    { auto client = connected(); }
    const auto server = pipeline_->find("server");
    for (int i = 0; i < 2; ++i) {
      ASSERT_NE(gst_element_set_state(server.get(), GST_STATE_READY), GST_STATE_CHANGE_FAILURE);
      g_object_set(server.get(), "port", 0, nullptr);
      ASSERT_NE(gst_element_set_state(server.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_FAILURE);
      auto client = connected();
      EXPECT_EQ(exchange(&client, numbers({i, 2, 3, 4})), numbers({i, 2, 3, 4}));
    }
  }
}

TEST_F(EdgeServer, ASourceStartsWhileItIsFlushed) {
  start_while_flushed("tensor_query_serversrc port=0");
}

TEST_F(EdgeServer, ThePortIsThatOfTheUserWhenItHasStopped) {
  play(kFour);
  EXPECT_NE(port(), 0u);
  EXPECT_TRUE(pipeline_->reaches(GST_STATE_NULL));
  EXPECT_EQ(port(), 0u);
}

TEST_F(EdgeServer, NeedsNoClient) {
  play(kFour);
  { auto client = connected(); }
  ASSERT_TRUE(clients_become(0));
  auto next = connected();
  EXPECT_EQ(exchange(&next, numbers({1, 2, 3, 4})), numbers({1, 2, 3, 4}));
}

TEST_F(EdgeServer, RejectsSettingsThatItCannotUse) {
  const auto error = [](const std::string& options, const char* caps = kFour) {
    return error_of_pipeline("tensor_query_serversrc port=0 " + options + " ! " + caps +
                             " ! tensor_query_serversink");
  };
  EXPECT_SAYS(error("host=no.such.host.invalid"), "no.such.host.invalid:0");
  EXPECT_SAYS(error("host=0.0.0.0 allow=a/b/c"), "allow");
  EXPECT_SAYS(error("", "application/x,text=(string)\"a@b\""), "@");
  EXPECT_SAYS(error_of_pipeline("tensor_query_serversrc port=0 ! fakesink"),
              "WEIR-1004: the tensors of the requests are not known");
}

TEST_F(EdgeServer, NamesAPortThatIsTaken) {
  play(kFour);
  const std::string taken = std::to_string(port());
  const auto error = error_of_pipeline("tensor_query_serversrc id=1 port=" + taken + " ! " + kFour +
                                       " ! tensor_query_serversink id=1");
  EXPECT_SAYS(error, "localhost:" + taken);
  EXPECT_SAYS(error, "in use");
}

TEST_F(EdgeServer, EachPairNeedsAnIdOfItsOwn) {
  play(kFour);
  EXPECT_SAYS(error_of_pipeline("tensor_query_serversrc port=0 ! " + std::string(kFour) +
                                " ! tensor_query_serversink"),
              "another tensor_query_serversrc of this process has the same id");
}

TEST_F(EdgeServer, OtherMachinesAreAWarning) {
  const auto element = lone_element("tensor_query_serversrc host=0.0.0.0 port=0 ! fakesink");
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  EXPECT_SAYS(errors.next_warning(), "other machines can connect without encryption");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

}  // namespace edge_server_test
}  // namespace weir::test
