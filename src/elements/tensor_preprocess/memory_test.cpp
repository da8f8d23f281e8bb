// Memory of tensor_preprocess: pools, and the allocation that the peer requests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>
#include <set>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_preprocess/preprocess_test_support.hpp"

namespace weir::preprocess_test {
namespace tensor_preprocess_memory_test {

GstBuffer* with_regions(size_t count) {
  GstBuffer* in = frame(ramp(12));
  for (size_t i = 0; i < count; ++i)
    gst_buffer_add_video_region_of_interest_meta(in, "face", static_cast<guint>(i % 4), 1, 1, 1);
  return in;
}

// Where a tensor starts when the peer requests alignment 4096 and 9000 bytes of padding.
std::string placement(const std::string& properties, GstBuffer* in) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  GstAllocationParams params;
  gst_allocation_params_init(&params);
  params.align = 4095;
  params.padding = 9000;
  gst_harness_set_propose_allocator(h.get(), nullptr, &params);
  gst_harness_set_src_caps_str(h.get(), video("GRAY8", 4, 3).c_str());
  if (gst_harness_push(h.get(), in) != GST_FLOW_OK) return "no buffer";
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  GstMemory* memory = gst_buffer_peek_memory(out.get(), 0);
  gsize offset = 0, all = 0;
  const gsize bytes = gst_memory_get_sizes(memory, &offset, &all);
  const Mapped map(out.get(), GST_MAP_READ);
  return std::to_string(bytes) + " bytes at " +
         std::to_string(reinterpret_cast<uintptr_t>(map.bytes().data()) % 4096) +
         (all >= offset + bytes + 9000 ? ", padded" : "");
}

TEST(PreprocessMemory, IsAllocatedAsDownstreamRequests) {
  const std::string gray = "channel-order=GRAY width=2 height=1 ";
  EXPECT_EQ(placement(gray, frame(ramp(12))), "2 bytes at 0, padded");
  EXPECT_EQ(placement(gray + "regions=meta max-regions=3", with_regions(2)),
            "6 bytes at 0, padded");
  EXPECT_EQ(placement(gray + "regions=meta", with_regions(2)), "132 bytes at 0, padded");
}

TEST(PreprocessMemory, NeedsNoCopyForAnEngineWithRequirements) {
  const std::string model = testing::TempDir() + "weir-preprocess-memory-model.bin";
  std::ofstream(model) << "x";
  const Harness h{gst_harness_new_parse(
      ("tensor_preprocess layout=NCHW channel-order=GRAY width=4 height=2 type=float32 ! "
       "tensor_filter framework=fake custom=alignment:4096,padding:9000 model=" +
       model)
          .c_str())};
  gst_harness_set_src_caps_str(h.get(), video("GRAY8", 4, 3).c_str());
  ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(12))), GST_FLOW_OK);
  gst_buffer_unref(gst_harness_pull(h.get()));
  EXPECT_EQ(test::stat(h, "tensor_filter", "bytes-copied"), 0u);
}

TEST(PreprocessMemory, OfFlexibleBatchesIsPooled) {
  auto h = harness("regions=meta width=2 height=1", video("GRAY8", 4, 3));
  const auto push_frames = [&](const std::vector<size_t>& counts) {
    for (const size_t count : counts) {
      ASSERT_EQ(gst_harness_push(h.get(), with_regions(count)), GST_FLOW_OK);
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_EQ(gst_buffer_get_size(out.get()), kTensorHeaderBytes + count * 6);
      const Mapped map(out.get(), GST_MAP_READ);
      const auto header = read_tensor_chunk(std::as_bytes(map.as<const uint8_t>()));
      ASSERT_TRUE(header);
      EXPECT_EQ(header->spec.shape[3], count);
    }
  };
  push_frames({5, 8, 6, 8, 5, 7});
  EXPECT_EQ(stat(h, "pool-allocated"), 1u);
  push_frames({9, 16, 3, 10});
  EXPECT_EQ(stat(h, "pool-allocated"), 2u);
  // Many frames in a row need far fewer: the large buffers are replaced, once.
  push_frames(std::vector<size_t>(64, 1));
  EXPECT_EQ(stat(h, "pool-allocated"), 3u);
  push_frames(std::vector<size_t>(200, 1));
  EXPECT_EQ(stat(h, "pool-allocated"), 3u);
}

TEST(PreprocessMemory, OfAHeldBatchIsNotReused) {
  auto h = harness("regions=meta width=1 height=1 channel-order=GRAY", video("GRAY8", 4, 3));
  std::vector<Ref<GstBuffer>> held;
  std::set<const GstMemory*> memories;
  for (size_t count = 1; count <= 20; ++count) {
    ASSERT_EQ(gst_harness_push(h.get(), with_regions(count)), GST_FLOW_OK);
    held.push_back(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())));
    memories.insert(gst_buffer_peek_memory(held.back().get(), 0));
  }
  EXPECT_EQ(memories.size(), 20u);
  for (size_t i = 0; i < held.size(); ++i)
    EXPECT_EQ(gst_buffer_get_size(held[i].get()), kTensorHeaderBytes + i + 1);
}

}  // namespace tensor_preprocess_memory_test
}  // namespace weir::preprocess_test
