// tensor_query_serversink: frames without a request, and a missing source.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <string>

#include "becomes.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace weir::test {
namespace {

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

TEST(TensorQueryServersink, NeedsASourceOfItsId) {
  const std::string error =
      error_of_pipeline(std::string(kFrames) + "tensor_query_serversink id=7");
  EXPECT_SAYS(error, "WEIR-1004: no tensor_query_serversrc has the same id");
  EXPECT_SAYS(error, "offered: tensor_query_serversink id=7");
  EXPECT_SAYS(error, "fix: tensor_query_serversrc id=7");
}

TEST(TensorQueryServersink, AnswersWithoutWaitingForAClock) {
  PlayedPipeline p(std::string(kFrames) + "tensor_query_serversink name=end id=7");
  gboolean sync = TRUE;
  g_object_get(p.find("end").get(), "sync", &sync, nullptr);
  EXPECT_FALSE(sync);
}

}  // namespace
}  // namespace weir::test
