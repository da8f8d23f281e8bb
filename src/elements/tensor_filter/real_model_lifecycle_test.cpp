// Sharing and replacing with the engines that Weir ships: -x and |x| as models of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "elements/tensor_filter/adder_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace real_model_lifecycle_test {

using namespace weir::test;
using namespace weir::engine_test;

struct Models {
  std::string negative, positive, wide;  // -x; max(x, 0); -x of another size
};
std::string written(const AdderFiles& files, const std::string& name,
                    const std::vector<std::byte>& bytes) {
  return files.write(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}
Models onnx_models(const AdderFiles& files) {
  const auto model = [](const std::string& op, const std::string& width) {
    return OnnxBuilder()
        .input("x", kFloat, {"1", width})
        .output("y", kFloat, {"1", width})
        .node(op, {"x"}, {"y"})
        .bytes();
  };
  return {written(files, "n.onnx", model("Neg", "4")), written(files, "p.onnx", model("Relu", "4")),
          written(files, "w.onnx", model("Neg", "5"))};
}
Models tflite_models(const AdderFiles& files) {
  const auto relu = TfliteBuilder()
                        .input("x", kTfFloat, {1, 4})
                        .output("y", kTfFloat, {1, 4})
                        .node(kOpRelu, {"x"}, {"y"});
  return {written(files, "n.tflite", tflite_negation({1, 4}).bytes()),
          written(files, "p.tflite", relu.bytes()),
          written(files, "w.tflite", tflite_negation({1, 5}).bytes())};
}

class RealModelLifecycle : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    models_ =
        std::string(GetParam()) == "onnxruntime" ? onnx_models(files_) : tflite_models(files_);
    const auto text = start_error("tensor_filter model=" + models_.negative);
    if (text.find("WEIR-3002") != std::string::npos) GTEST_SKIP() << text;
    ASSERT_EQ(text, "");
  }
  std::string line(const std::string& more) const {
    return "tensor_filter is-updatable=true model=" + models_.negative + " " + more;
  }
  static std::vector<float> pushed(const Harness& h) {
    if (gst_harness_push(h.get(), frame<float>({-2, -1, 1, 2})) != GST_FLOW_OK) return {};
    return values<float>(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())).get());
  }
  static void set_model(const Harness& h, const std::string& model) {
    g_object_set(find_element(h, "tensor_filter").get(), "model", model.c_str(), nullptr);
  }

  const std::vector<float> negated_{2, 1, -1, -2}, clipped_{0, 0, 1, 2};
  AdderFiles files_;
  Models models_;
};

TEST_P(RealModelLifecycle, AReloadReplacesTheModelForAllFiltersOfTheKey) {
  const auto launch = line("shared-tensor-filter-key=real");
  auto first = make_harness(launch, kAdderCaps), second = make_harness(launch, kAdderCaps);
  EXPECT_EQ(pushed(first), negated_);
  EXPECT_EQ(pushed(second), negated_);
  EXPECT_EQ(stat(second, "tensor_filter", "shared-by"), 2u);
  for (int i = 0; i < 5; ++i) {
    set_model(first, models_.positive);
    EXPECT_EQ(pushed(first), clipped_);
    EXPECT_EQ(pushed(second), clipped_);
    set_model(second, models_.negative);
    EXPECT_EQ(pushed(first), negated_);
    EXPECT_EQ(pushed(second), negated_);
  }
  EXPECT_EQ(stat(first, "tensor_filter", "reloads"), 10u);
}

TEST_P(RealModelLifecycle, AModelOfAnotherSizeIsRejected) {
  auto h = make_harness(line(""), kAdderCaps);
  Errors messages(h);
  EXPECT_EQ(pushed(h), negated_);
  set_model(h, models_.wide);
  EXPECT_SAYS(messages.next_warning(),
              "first difference: input 0 is float32 5:1, needed is float32 4:1");
  EXPECT_EQ(pushed(h), negated_);
}

TEST_P(RealModelLifecycle, AnIdleModelIsClosedAndRunsAgain) {
  auto h = make_harness(line("suspend=1"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  for (int i = 0; i < 3; ++i) {
    wait_until_suspended(filter.get());
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 0u);
    EXPECT_EQ(pushed(h), negated_);
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, RealModelLifecycle,
                         ::testing::Values("onnxruntime", "tensorflow-lite"));

}  // namespace real_model_lifecycle_test
