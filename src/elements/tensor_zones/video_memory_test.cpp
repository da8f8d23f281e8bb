// Tests that following and counting objects neither copies nor maps the video that they are in.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "elements/tests/device_memory_test_support.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir {
namespace video_memory_test {

using namespace weir::test;
using testing_memory::DeviceAllocator;
using testing_memory::Refuses;

constexpr int kWidth = 64, kHeight = 48, kFrames = 5;

class VideoMemory : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) /
            ("weir-video-memory-" + std::to_string(getpid()) + ".json");
    std::ofstream(path_) << R"({"version":1,"zones":[{"name":"gate","line":[[0,30],[64,30]]}]})";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  // A frame of video with an object whose lower edge is 6 rows lower in each frame.
  Ref<GstBuffer> picture(int number) {
    auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
    gst_buffer_append_memory(out.get(), device_.holding(std::vector<uint8_t>(kWidth * kHeight, 9)));
    GST_BUFFER_PTS(out.get()) = static_cast<GstClockTime>(number) * GST_SECOND / 10;
    gst_buffer_add_video_region_of_interest_meta(out.get(), "person", 20,
                                                 static_cast<guint>(6 * number), 16, 20);
    return out;
  }

  std::filesystem::path path_;
  DeviceAllocator device_{Refuses::Nothing};
};

TEST_F(VideoMemory, IsNeitherMappedNorCopiedBesideABranchThatCounts) {
  const auto h = make_harness(
      "tee name=both both. ! fakesink name=video sync=false async=false "
      "both. ! tensor_from_roi ! tensor_tracker ! tensor_zones zones=" +
          path_.string(),
      video("GRAY8", kWidth, kHeight));
  const auto sink = find_element(h, "fakesink");
  for (int i = 0; i < kFrames; ++i) {
    auto in = picture(i);
    GstMemory* const memory = gst_buffer_peek_memory(in.get(), 0);
    auto results = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in.release()));
    ASSERT_TRUE(results);
    for (guint n = 0; n < gst_buffer_n_memory(results.get()); ++n)
      EXPECT_NE(gst_buffer_peek_memory(results.get(), n), memory);
    GstSample* shown = nullptr;
    g_object_get(sink.get(), "last-sample", &shown, nullptr);
    ASSERT_TRUE(shown);
    EXPECT_EQ(gst_buffer_peek_memory(gst_sample_get_buffer(shown), 0), memory) << i;
    gst_sample_unref(shown);
  }
  EXPECT_EQ(device_.mappings(), 0);
  EXPECT_EQ(stat(h, "tensor_zones", "events"), 1u) << "it did count";
  EXPECT_LT(stat(h, "tensor_tracker", "bytes-copied"), uint64_t{kFrames * 64})
      << "rows of results, no picture of 3072 bytes";
  EXPECT_EQ(stat(h, "tensor_zones", "bytes-copied"), 0u);
}

// What the test above counts is seen where an element reads the picture.
TEST_F(VideoMemory, IsMappedByAnElementThatReadsIt) {
  const auto h = make_harness("tensor_converter", video("GRAY8", kWidth, kHeight));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), picture(0).release()));
  ASSERT_TRUE(out);
  EXPECT_EQ(content(out.get()).at(0), 9);
  EXPECT_GT(device_.mappings(), 0);
}

}  // namespace video_memory_test
}  // namespace weir
