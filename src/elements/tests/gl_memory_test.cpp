// Pictures in OpenGL textures: read through GStreamer's GL memory if the caps are of system memory,
// otherwise rejected with a pipeline that works. Needs GL without a display (Mesa).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <fstream>

#include "elements/tests/pipeline_test_support.hpp"

namespace gl_memory_test {

using namespace weir::test;

bool has_elements() {
  const auto found = Ref<GstElementFactory>::adopt(gst_element_factory_find("gldownload"));
  return static_cast<bool>(found);
}

class GlMemory : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_elements()) GTEST_SKIP() << "no GL elements: apt-get install gstreamer1.0-gl";
    // In a separate process: without GL, GStreamer's elements log warnings and leak an object.
    static const int missing = std::system(
        "G_DEBUG= GST_TRACERS= gst-launch-1.0 -q gltestsrc num-buffers=1 ! gldownload ! fakesink");
    if (missing != 0)
      GTEST_SKIP() << "no GL without a screen: apt-get install libegl-mesa0 libgl1-mesa-dri";
  }
};

// What the sink sees of four frames, and whether the first element received them as textures.
struct Seen {
  std::vector<Bytes> frames;
  uint64_t in_textures = 0, copied = 0;
};

bool is_in_texture(GstBuffer* buffer) {
  bool all = gst_buffer_n_memory(buffer) > 0;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i)
    all =
        all && g_str_has_prefix(gst_buffer_peek_memory(buffer, i)->allocator->mem_type, "GLMemory");
  return all;
}
GstPadProbeReturn count_textures(GstPad*, GstPadProbeInfo* info, gpointer count) {
  *static_cast<uint64_t*>(count) += is_in_texture(GST_PAD_PROBE_INFO_BUFFER(info));
  return GST_PAD_PROBE_OK;
}

// `line` starts with the observed element, named `first`.
Seen seen_downstream(const std::string& caps, const std::string& between, const std::string& line) {
  Seen out;
  PlayedPipeline pipeline("videotestsrc num-buffers=4 horizontal-speed=3 ! video/x-raw," + caps +
                          " ! " + between + line + " ! tensor_sink name=end");
  const auto first = pipeline.find("first");
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(first.get(), "sink"));
  gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_BUFFER, count_textures, &out.in_textures,
                    nullptr);
  pipeline.watch("end");
  EXPECT_EQ(pipeline.plays_to_its_end(), "") << line;
  out.frames = pipeline.seen<uint8_t>("end");
  out.copied = pipeline.stat("first", "bytes-copied");
  return out;
}

struct Line {
  const char* caps;
  std::string elements;
  bool is_copied;  // makes the converter copy them
};

TEST_F(GlMemory, IsReadLikeSystemMemory) {
  const char* rgba = "format=RGBA,width=32,height=16";
  const char* apart = "format=RGB,width=33,height=17";
  const char* planes = "format=NV12,width=64,height=32";
  const Line lines[] = {
      {rgba, "tensor_converter name=first", false},
      {apart, "tensor_converter name=first", true},
      {rgba, "tensor_converter name=first frames-per-tensor=2", true},
      {rgba, "tensor_converter name=first ! tensor_transform mode=typecast option=float32", false},
      {rgba, "tensor_converter name=first ! tensor_transform mode=arithmetic option=add:1", false},
      {apart, "tensor_converter name=first ! tensor_transform mode=arithmetic option=add:1", true},
      {rgba, "tensor_converter name=first ! tensor_transform mode=transpose option=1:0:2:3", false},
      {rgba, "tensor_converter name=first ! tensor_aggregator frames-out=3 frames-flush=1", false},
      {rgba, "tensor_converter name=first ! tensor_mux", false},
      {rgba, "tensor_converter name=first ! tensor_split tensorseg=4:32:8:1,4:32:8:1", false},
      {rgba, "tensor_preprocess name=first width=20 height=20 fit=letterbox", false},
      {apart, "tensor_preprocess name=first width=8 height=8 method=area", false},
      {planes, "tensor_preprocess name=first width=24 height=16 layout=NCHW", false},
  };
  for (const Line& line : lines) {
    const Seen system = seen_downstream(line.caps, "", line.elements);
    const Seen gl = seen_downstream(line.caps, "glupload ! gldownload ! ", line.elements);
    EXPECT_GE(system.frames.size(), 2u) << line.elements;
    EXPECT_EQ(gl.frames, system.frames) << line.caps << " ! " << line.elements;
    EXPECT_EQ(system.in_textures, 0u);
    EXPECT_EQ(gl.in_textures, 4u) << line.caps << " ! " << line.elements;
    if (line.is_copied)
      EXPECT_GT(gl.copied, 0u) << line.elements;
    else
      EXPECT_EQ(gl.copied, 0u) << line.elements;
  }
}

// The engine sees the bytes of the textures that the converter passes on.
TEST_F(GlMemory, IsMappedForAnEngine) {
  PlayedPipeline pipeline(
      "videotestsrc num-buffers=4 ! video/x-raw,format=RGBA,width=32,height=16 ! glupload ! "
      "gldownload ! tensor_converter ! tensor_sink name=end");
  std::vector<Ref<GstBuffer>> frames;
  g_signal_connect(pipeline.find("end").get(), "new-data",
                   G_CALLBACK(+[](GstElement*, GstBuffer* b, std::vector<Ref<GstBuffer>>* seen) {
                     seen->push_back(Ref<GstBuffer>::share(b));
                   }),
                   &frames);
  ASSERT_EQ(pipeline.plays_to_its_end(), "");
  ASSERT_EQ(frames.size(), 4u);
  const std::string model = testing::TempDir() + "weir-gl-memory.bin";
  std::ofstream(model) << "the engine ignores the frame";
  const auto h =
      make_harness("tensor_filter framework=fake model=" + model, tensors("float32", "4:128:1:1"));
  for (const auto& in : frames) {
    EXPECT_TRUE(is_in_texture(in.get()));
    const Bytes bytes = content(in.get());
    const auto of_texture =
        Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), gst_buffer_ref(in.get())));
    const auto of_system = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(bytes)));
    EXPECT_EQ(content(of_texture.get()), content(of_system.get()));
  }
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
}

TEST_F(GlMemory, ThatIsSharedIsNotWritten) {
  const std::string source =
      "videotestsrc num-buffers=4 ! video/x-raw,format=RGBA,width=32,height=16 ! ";
  PlayedPipeline pipeline(source +
                          "glupload ! gldownload ! tee name=t "
                          "t. ! queue ! tensor_converter ! tensor_transform mode=arithmetic "
                          "option=add:1 ! tensor_sink name=changed "
                          "t. ! queue ! tensor_converter ! tensor_sink name=kept");
  PlayedPipeline plain(source + "tensor_converter ! tensor_sink name=kept");
  pipeline.watch("changed");
  pipeline.watch("kept");
  plain.watch("kept");
  ASSERT_EQ(pipeline.plays_to_its_end(), "");
  ASSERT_EQ(plain.plays_to_its_end(), "");
  const auto kept = pipeline.seen<uint8_t>("kept");
  EXPECT_EQ(kept, plain.seen<uint8_t>("kept"));
  auto changed = kept;
  for (auto& frame : changed)
    for (auto& byte : frame) byte = static_cast<uint8_t>(std::min(byte + 1, 255));
  EXPECT_EQ(pipeline.seen<uint8_t>("changed"), changed);
}

TEST_F(GlMemory, InCapsIsRejectedWithAWorkingFix) {
  const char* sources[] = {"gltestsrc num-buffers=2 ! ",
                           "videotestsrc num-buffers=2 ! glupload ! glcolorconvert ! ",
                           "videotestsrc num-buffers=2 ! video/x-raw,format=NV12 ! glupload ! "};
  const std::string elements[] = {"tensor_converter", "tensor_preprocess"};
  for (const std::string source : sources) {
    for (const auto& element : elements) {
      const std::string downstream =
          element == "tensor_preprocess" ? " width=4 height=4 ! fakesink" : " ! fakesink";
      for (const char* between : {"", "queue ! "}) {
        const std::string text = error_of_pipeline(source + between + element + downstream);
        EXPECT_SAYS(text, "WEIR-2002: the video is in device memory");
        EXPECT_SAYS(text, "offered: memory:GLMemory");
        const auto fix = text.find("fix: ");
        ASSERT_NE(fix, std::string::npos) << text;
        const std::string line = text.substr(fix + 5, text.find('\n', fix) - fix - 5);
        EXPECT_EQ(line, "glcolorconvert ! gldownload ! " + element);
        EXPECT_EQ(error_of_pipeline(source + line + downstream), "");
      }
    }
  }
}

}  // namespace gl_memory_test
