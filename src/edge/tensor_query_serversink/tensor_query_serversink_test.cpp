// tensor_query_serversink: frames without a request or of another server, and a missing source.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>

#include "becomes.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "transport/edge/query_client_test_support.hpp"

namespace weir::test {
namespace tensor_query_serversink_test {

constexpr char kFrames[] =
    "videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=4,height=1,framerate=30/1 ! "
    "tensor_converter ! ";
constexpr char kSource[] =
    " tensor_query_serversrc name=server protocol=oip port=0 "
    "caps=other/tensor,dimension=(string)4,type=(string)uint8,framerate=0/1 ! fakesink async=false";

TEST(TensorQueryServersink, RejectsFramesWithoutARequest) {
  const std::string error =
      error_of_pipeline(std::string(kFrames) + "tensor_query_serversink limit=1" + kSource);
  EXPECT_SAYS(error, "WEIR-1004: frames arrive that do not belong to a request");
  EXPECT_SAYS(error, "offered: 1 in a row");
  EXPECT_SAYS(error, "fix: tensor_query_serversink limit=2");
}

TEST(TensorQueryServersink, TheDefaultOfLimitIsOne) {
  const std::string error =
      error_of_pipeline(std::string(kFrames) + "tensor_query_serversink" + kSource);
  EXPECT_SAYS(error, "offered: 1 in a row");
  EXPECT_SAYS(error, "fix: tensor_query_serversink limit=2");
}

TEST(TensorQueryServersink, DropsFewerThanLimit) {
  PlayedPipeline p(std::string(kFrames) + "tensor_query_serversink name=end limit=4" + kSource);
  gst_element_set_state(p.get(), GST_STATE_PLAYING);
  EXPECT_TRUE(
      becomes_true([&] { return p.stat("end", "dropped-policy") == 3; }, "three dropped frames"));
  EXPECT_EQ(p.stat("end", "received"), 3u);
  EXPECT_EQ(p.stat("end", "consumed"), 0u);
}

// The requests of a client of the first source reach the sinks of both.
class SinkOfAnotherProtocol : public ::testing::Test {
 protected:
  void play(const std::string& options) {
    const std::string caps = "other/tensor,dimension=(string)4,type=(string)uint8,framerate=0/1";
    pipeline_ = std::make_unique<PlayedPipeline>(
        "tensor_query_serversrc name=edge port=0 ! " + caps +
        " ! tee name=both ! tensor_query_serversink name=other id=1 " + options +
        " both. ! tensor_query_serversink tensor_query_serversrc id=1 protocol=oip port=0 caps=" +
        caps + " ! fakesink async=false");
    ASSERT_TRUE(pipeline_->reaches(GST_STATE_PLAYING));
    guint port = 0;
    g_object_get(pipeline_->find("edge").get(), "port", &port, nullptr);
    client_ = std::make_unique<edge::test::RawClient>(static_cast<uint16_t>(port));
    client_->connect();
  }
  const std::vector<wire::test::Bytes> frame_{wire::test::from_text("abcd")};
  std::unique_ptr<PlayedPipeline> pipeline_;
  std::unique_ptr<edge::test::RawClient> client_;
};

TEST_F(SinkOfAnotherProtocol, NamesTheSourceOfTheRequest) {
  play("");
  client_->request(frame_);
  const std::string error = pipeline_->outcome();
  EXPECT_SAYS(error,
              "WEIR-1004: frames arrive that answer requests of a server with another protocol");
  EXPECT_SAYS(error,
              "offered: at tensor_query_serversink id=1: requests of tensor_query_serversrc id=0");
  EXPECT_SAYS(error, "fix: tensor_query_serversink id=0 for these frames");
}

TEST_F(SinkOfAnotherProtocol, DropsFewerThanLimit) {
  play("limit=3");
  for (int i = 0; i < 2; ++i) {
    client_->request(frame_);
    EXPECT_EQ(client_->response(), frame_);
  }
  EXPECT_EQ(pipeline_->stat("other", "dropped-policy"), 2u);
  EXPECT_EQ(pipeline_->stat("other", "consumed"), 0u);
}

TEST(TensorQueryServersink, NeedsASourceOfItsId) {
  const std::string error =
      error_of_pipeline(std::string(kFrames) + "tensor_query_serversink id=7");
  EXPECT_SAYS(error, "WEIR-1004: no tensor_query_serversrc has the same id");
  EXPECT_SAYS(error, "offered: tensor_query_serversink id=7");
  EXPECT_SAYS(error, "fix: tensor_query_serversrc id=7");
}

TEST(TensorQueryServersink, NeedsASourceForFramesWithoutCapsToo) {
  const std::string error = error_of_pipeline("fakesrc num-buffers=1 ! tensor_query_serversink");
  EXPECT_SAYS(error, "WEIR-1004: no tensor_query_serversrc has the same id");
  EXPECT_SAYS(error, "fix: tensor_query_serversrc id=0");
}

TEST(TensorQueryServersink, RejectsFramesWithoutCaps) {
  const std::string error =
      error_of_pipeline(std::string("fakesrc num-buffers=1 ! tensor_query_serversink") + kSource);
  EXPECT_SAYS(error, "a buffer arrived before caps");
}

TEST(TensorQueryServersink, AnswersWithoutWaitingForAClock) {
  PlayedPipeline p(std::string(kFrames) + "tensor_query_serversink name=end id=7");
  gboolean sync = TRUE;
  g_object_get(p.find("end").get(), "sync", &sync, nullptr);
  EXPECT_FALSE(sync);
}

}  // namespace tensor_query_serversink_test
}  // namespace weir::test
