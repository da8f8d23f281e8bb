// A capsfilter that describes tensors without their format, downstream of a source without caps:
// it sends caps if the downstream element offers one structure only
// (docs/compatibility/types-and-caps.md 1.5). What elements say of their output before caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>
#include <fstream>

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

// A pipeline whose source never sends caps: the capsfilter before the element offers these.
class PipelineBeforeCaps {
 public:
  PipelineBeforeCaps(const std::string& offered, const std::string& element)
      : pipeline_(Ref<GstElement>::adopt(gst_parse_launch(
            ("appsrc ! capsfilter caps=\"" + offered + "\" ! " + element + " name=element").c_str(),
            nullptr))),
        element_(Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "element"))),
        source_(Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"))) {
    gst_element_set_state(pipeline_.get(), GST_STATE_PAUSED);
  }
  PipelineBeforeCaps(const PipelineBeforeCaps&) = delete;
  PipelineBeforeCaps& operator=(const PipelineBeforeCaps&) = delete;
  ~PipelineBeforeCaps() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }

  void set(const char* property, const std::string& value) {
    gst_util_set_object_arg(G_OBJECT(element_.get()), property, value.c_str());
  }
  std::string output() const {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(source_.get(), nullptr));
    return weir::gst::UniqueText(gst_caps_to_string(caps.get())).get();
  }

 private:
  Ref<GstElement> pipeline_, element_;
  Ref<GstPad> source_;
};

TEST(BeforeCaps, AConverterReportsWhatItsPropertiesMake) {
  PipelineBeforeCaps pipeline("video/x-raw,format=RGB,width=4,height=2,framerate=0/1",
                              "tensor_converter");
  EXPECT_SAYS(pipeline.output(), "3:4:2:1");
  pipeline.set("frames-per-tensor", "5");
  EXPECT_SAYS(pipeline.output(), "3:4:2:5");
}

// Each configuration of the head reads the file.
TEST(BeforeCaps, ADecoderReadsItsFilesOnceForAllQueries) {
  const std::string priors = testing::TempDir() + "weir-two-priors.txt";
  std::ofstream(priors) << "0.5 0.5\n0.5 0.5\n1 1\n1 1\n";
  const std::string custom = "head:ssd,priors:" + priors + ",input:8:8,name:";
  PipelineBeforeCaps pipeline(
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\\\"4:2:1,3:2:1\\\","
      "types=(string)\\\"float32,float32\\\",framerate=0/1",
      "tensor_decoder mode=detection custom=" + custom + "front");
  const std::string output = pipeline.output();
  EXPECT_SAYS(output, "weir-source=(string)front");
  std::filesystem::rename(priors, priors + ".away");
  EXPECT_EQ(pipeline.output(), output);
  std::filesystem::rename(priors + ".away", priors);
  pipeline.set("custom", custom + "back");
  EXPECT_SAYS(pipeline.output(), "weir-source=(string)back");
  std::filesystem::remove(priors);
  EXPECT_SAYS(pipeline.output(), "weir-source=(string)back");
}

// As the caps that follow are.
TEST(BeforeCaps, PropertiesOfADecoderMayChange) {
  const Harness h{gst_harness_new_parse("tensor_decoder mode=octet_stream")};
  g_object_set(find_element(h, "tensor_decoder").get(), "mode", "direct_video", nullptr);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "3:8:4:1").c_str());
  EXPECT_SAYS(caps_text(h), "video/x-raw");
}

TEST(BeforeCaps, PropertiesOfADecoderThatCannotReadTheCapsHaveNoEffect) {
  const Harness h{gst_harness_new_parse("tensor_decoder mode=octet_stream")};
  g_object_set(find_element(h, "tensor_decoder").get(), "mode", "pose", nullptr);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "3:8:4:1").c_str());
  EXPECT_SAYS(caps_text(h), "application/octet-stream");
}

}  // namespace
}  // namespace described_caps_test
