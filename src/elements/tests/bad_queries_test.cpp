// Queries with caps of every kind, as upstream and downstream elements try them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_queries_test {

using namespace weir::testing_bad_input;

// The caps of all elements, and some that are invalid or incomplete.
std::vector<std::string> tried_caps() {
  std::vector<std::string> all{
      "ANY",
      "EMPTY",
      "text/x-raw",
      "other/tensors",
      "other/tensors,format=static,num_tensors=1",
      "other/tensors,format=static,num_tensors=2,dimensions=(string)4:4,types=(string)uint8",
      "other/tensors,format=static,num_tensors=17,dimensions=(string)1,types=(string)uint8",
      "other/tensors,format=static,num_tensors=1,dimensions=(string)4294967295:4294967295:"
      "4294967295,types=(string)float64,framerate=30/1",
      "other/tensor,dimension=(string)0:x,type=(string)none,framerate=0/1",
      "video/x-raw,format=RGB,width=2147483647,height=2147483647,framerate=30/1",
      "video/x-raw,format={RGB,NV12},width=[1,10],height=0",
      "audio/x-raw,format=S16LE,rate=2147483647,channels=2147483647,layout=interleaved",
      "application/octet-stream;other/tensors,format={static,flexible,sparse}"};
  for (const auto& subject : subjects()) all.push_back(subject.caps);
  return all;
}

class BadQuery : public EachElement {};

TEST_P(BadQuery, PostsNoError) {
  Bench bench(GetParam());
  ASSERT_EQ(bench.start_without_caps(), "");
  for (const auto& caps : tried_caps()) EXPECT_EQ(bench.query(caps), "") << caps;
  ASSERT_EQ(bench.set_caps(GetParam().caps), "");
  for (const auto& caps : tried_caps()) EXPECT_EQ(bench.query(caps), "") << caps;
  EXPECT_EQ(bench.push(GetParam().good_frame()), "");
}

WEIR_FOR_EACH_ELEMENT(BadQuery);

}  // namespace bad_queries_test
