// A capsfilter that describes tensors without their format, downstream of a source without caps:
// it sends caps if the downstream element offers one structure only
// (docs/compatibility/types-and-caps.md 1.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bad_input_subjects_test_support.hpp"
#include "pipeline_test_support.hpp"

using namespace weir::test;

namespace described_caps_test {
namespace {

// Plays a frame of 64 bytes through a capsfilter with these fields.
std::string outcome(const std::string& fields, const std::string& element) {
  return error_of_pipeline(
      "fakesrc num-buffers=1 sizetype=fixed sizemax=64 format=time ! capsfilter "
      "caps=\"other/tensors," +
      fields + ",framerate=(fraction)0/1\" ! " + element);
}

class DescribedCaps : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(
    Elements, DescribedCaps,
    testing::Values<std::string>(
        "tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=0 operator=GE "
        "supplied-value=0 then=PASSTHROUGH else=SKIP ! fakesink",
        "tensor_rate ! fakesink", "tensor_reposink slot-index=77", "tensor_sink",
        "tensor_demux ! fakesink", "tensor_split tensorseg=2,2 name=s s.src_0 ! fakesink",
        "tensor_mux ! fakesink", "tensor_merge mode=linear option=0 ! fakesink",
        "tensor_aggregator frames-out=1 frames-dim=2 ! fakesink",
        "tensor_transform mode=typecast option=uint8 ! fakesink",
        "tensor_decoder mode=octet_stream ! fakesink", "tensor_debug ! fakesink",
        "tensor_tracker ! fakesink", weir::testing_bad_input::fake_filter() + " ! fakesink"));

TEST_P(DescribedCaps, AreThoseOfAStaticStream) {
  EXPECT_EQ(outcome("num_tensors=1,dimensions=(string)4:4,types=(string)float32", GetParam()), "");
}

TEST(DescribedCaps, StayOpenWithoutADescription) {
  EXPECT_SAYS(outcome("weir-columns=(string)x", "tensor_sink"),
              "Filter caps do not completely specify the output format");
}

}  // namespace
}  // namespace described_caps_test
