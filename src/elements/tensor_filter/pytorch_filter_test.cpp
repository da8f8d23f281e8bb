// PyTorch models in pipelines: properties that contradict the model, and replacing it. Skipped
// without libtorch.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torchscript_builder_test_support.hpp"

#include <fstream>

#include "elements/tests/element_test_support.hpp"

namespace pytorch_filter_test {

using namespace weir::test;

class PytorchFilter : public testing::Test {
 protected:
  void SetUp() override {
    write(path_, "torch.neg(x)");
    const auto error = start_error(filter("output=4:2 outputtype=float32"), caps_);
    if (error.find("WEIR-3002") != std::string::npos) GTEST_SKIP() << error;
    ASSERT_EQ(error, "");
  }
  static void write(const std::string& path, const std::string& result) {
    const auto bytes = weir::engine_test::torchscript(
        "def forward(self, x: Tensor) -> Tensor:\n  return " + result);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  static std::vector<float> pushed(const Harness& h) {
    const auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(h.get(), frame<float>({1, -2, 3, 4, 5, 6, 7, 8})));
    return out ? values<float>(out.get()) : std::vector<float>{};
  }
  std::string filter(const std::string& output) const {
    return "tensor_filter framework=pytorch model=" + path_ + " input=4:2 inputtype=float32 " +
           output;
  }

  const std::vector<float> kNegative{-1, 2, -3, -4, -5, -6, -7, -8};
  const std::string path_ = testing::TempDir() + "weir_negative.pt";
  const std::string caps_ = tensors("float32", "4:2");
};

// docs/compatibility/filter.md 4.3: an error for every framework.
TEST_F(PytorchFilter, RejectsOutputPropertiesThatContradictTheModel) {
  for (const char* wrong : {"output=4:3 outputtype=float32", "output=4:2 outputtype=uint8",
                            "outputtype=int8", "output=4 outputtype=float32", "output=8"})
    EXPECT_SAYS(start_error(filter(wrong), caps_), "WEIR-2001: output contradicts the model")
        << wrong;
  EXPECT_SAYS(start_error(filter("output=4:2,4:2 outputtype=float32,float32"), caps_),
              "WEIR-2001: output and the model have different numbers of tensors");
}

TEST_F(PytorchFilter, AcceptsOutputPropertiesThatMatchTheModel) {
  for (const char* right : {"", "output=4:2", "output=4:2:1:1 outputtype=float32"}) {
    auto h = make_harness(filter(right), caps_);
    EXPECT_EQ(pushed(h), kNegative) << right;
    EXPECT_SAYS(caps_text(h), "dimension=(string)4:2");
  }
}

// A TorchScript declares no tensors: those of the properties and of the stream count.
TEST_F(PytorchFilter, IsReplacedBetweenFramesUnlessTheTensorsDiffer) {
  const std::string other = testing::TempDir() + "weir_absolute.pt",
                    wide = testing::TempDir() + "weir_wide.pt";
  write(other, "torch.abs(x)");
  write(wide, "torch.cat([x, x], 0)");
  for (const char* output : {"", "output=4:2 outputtype=float32"}) {
    auto h = make_harness(filter(output) + " is-updatable=true", caps_);
    Errors messages(h);
    const auto element = find_element(h, "tensor_filter");
    EXPECT_EQ(pushed(h), kNegative) << output;
    g_object_set(element.get(), "model", other.c_str(), nullptr);
    EXPECT_EQ(pushed(h), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8})) << output;
    EXPECT_EQ(messages.next_warning(), "");
    g_object_set(element.get(), "model", wide.c_str(), nullptr);
    EXPECT_EQ(pushed(h), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8})) << output;
    EXPECT_SAYS(messages.next_warning(), "WEIR-3012");
    g_object_set(element.get(), "model", path_.c_str(), nullptr);
    EXPECT_EQ(pushed(h), kNegative) << output;
  }
}

}  // namespace pytorch_filter_test
