// Models that accept any number of tensors: their outputs are known when the stream is negotiated.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tests/element_test_support.hpp"

namespace open_count_test {

using namespace weir::test;

std::string filter(const std::string& custom, const std::string& properties = "") {
  const std::string path = testing::TempDir() + "weir_open_count_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=scaling model=" + path + " custom=factor:2," + custom + " " +
         properties;
}
const std::string kTwo = tensors("float32,float32", "2:1:1\\,1:2:1");
Ref<GstBuffer> two() {
  auto b = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append(b.get(), frame<float>({1, 2}));
  gst_buffer_append(b.get(), frame<float>({3, 4}));
  return b;
}

TEST(TensorFilterOpenCount, FollowsTheStream) {
  for (const char* isolate : {"", "isolate=process"}) {
    auto h = make_harness(filter("any:2", isolate), kTwo);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), two().release()));
    ASSERT_TRUE(out);
    EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
    EXPECT_EQ(values<float>(out.get()), (std::vector<float>{2, 4, 6, 8}));
    EXPECT_SAYS(caps_text(h), "num_tensors=(int)2");
    EXPECT_SAYS(caps_text(h), "2:1:1\\,1:2:1");
  }
}

TEST(TensorFilterOpenCount, AllowsFewerOutputs) {
  auto h = make_harness(filter("any:1"), kTwo);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), two().release()));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<float>(out.get()), (std::vector<float>{2, 4}));
}

TEST(TensorFilterOpenCount, CombinesTheExistingOutputs) {
  auto h = make_harness(filter("any:2", "output-combination=i0,o1"), kTwo);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), two().release()));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<float>(out.get()), (std::vector<float>{1, 2, 6, 8}));
}

TEST(TensorFilterOpenCount, ReportsErrorsOnceTheStreamIsKnown) {
  EXPECT_SAYS(start_error(filter("any:2", "output-combination=o2"), kTwo), "2 outputs, from o0 on");
  EXPECT_SAYS(start_error(filter("any:0"), kTwo), "the model declares no outputs for this stream");
  EXPECT_SAYS(start_error(filter("any:2", "output=2:1 outputtype=float32"), kTwo),
              "output= and the model's outputs for this stream differ in number");
}

}  // namespace open_count_test
