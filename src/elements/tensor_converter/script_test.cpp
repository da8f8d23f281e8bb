// tensor_converter mode=custom-script: tensors, caps and frame rates from a script. Skipped without
// Python or NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tensor_converter/converter_test_support.hpp"

namespace tensor_converter_script_test {

using namespace weir::testing_tensor_converter;

// Splits each buffer into halves; the first byte is the frame rate.
std::string halves() {
  const std::string path = testing::TempDir() + "weir_halves.py";
  std::ofstream(path) << "from nnstreamer_python import TensorShape\n"
                         "class CustomConverter:\n"
                         "  def convert(self, input_array):\n"
                         "    a = input_array[0]\n"
                         "    half = a[:len(a) // 2]\n"
                         "    return [TensorShape([len(half)])], [half], a[0], 1\n";
  return path;
}

class ConverterScript : public testing::Test {
 protected:
  void SetUp() override {
    auto h = script();
    Errors errors(h);
    if (gst_harness_push(h.get(), frame(Bytes{1, 1})) == GST_FLOW_OK) return;
    const auto error = caps_error("mode=custom-script:" + halves(), kBytes);
    if (error.find("WEIR-3002") != std::string::npos) GTEST_SKIP() << error;
  }
  static Harness script(const std::string& properties = "") {
    return harness("mode=custom-script:" + halves() + " " + properties, kBytes);
  }
  static constexpr char kBytes[] = "application/octet-stream,framerate=10/1";
};

TEST_F(ConverterScript, DeclaresTheTensorsAndTheRateOfEachFrame) {
  auto h = script();
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1:1:1:1, types=(string)uint8");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame({20, 7, 8, 9})));
  EXPECT_EQ(content(out.get()), (Bytes{20, 7}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2, types=(string)uint8");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)20/1");
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 50 * GST_MSECOND);
  out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame({5, 7, 8, 9})));
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)5/1");
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 50 * GST_MSECOND);
}

TEST_F(ConverterScript, HasItsFramesGathered) {
  auto h = script("frames-per-tensor=2");
  for (const uint8_t last : {1, 2})
    ASSERT_EQ(gst_harness_push(h.get(), frame({10, last, 0, 0})), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{10, 1, 10, 2}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:2, types=(string)uint8");
}

TEST_F(ConverterScript, ThatFailsIsAnErrorWithItsLine) {
  auto h = script();
  const auto error = get_error(h, frame({9}));
  EXPECT_SAYS(error, "WEIR-3006: the script failed: ValueError");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  EXPECT_EQ(gst_harness_push(h.get(), frame({1, 1})), GST_FLOW_OK) << "and goes on";
}

TEST_F(ConverterScript, ThatCannotBeReadIsReportedBeforePaused) {
  const auto element = lone_element("tensor_converter mode=custom-script:/nonexistent/x.py");
  Errors errors(element.get());
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  const auto error = errors.next();
  EXPECT_SAYS(error, "the script of the mode cannot be read: it does not exist");
  EXPECT_SAYS(error, "fix: tensor_converter mode=custom-script:/path/to/script.py");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

}  // namespace tensor_converter_script_test
