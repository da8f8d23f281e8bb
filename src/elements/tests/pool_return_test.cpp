// Buffers return to their pool once nothing shares their memories, and are reused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::test {
namespace pool_return_test {

using gst::Ref;
using gst::Unique;

constexpr guint kBuffers = 3;
constexpr gsize kBytes = 24;
constexpr char kCaps[] =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)6:4,types=uint8,framerate=30/1";

GQuark mark() {
  return g_quark_from_static_string("one-of-the-first");
}

// A pool of exactly this many buffers, each marked.
Ref<GstBufferPool> marked_pool() {
  auto pool = Ref<GstBufferPool>::adopt(gst_buffer_pool_new());
  GstStructure* config = gst_buffer_pool_get_config(pool.get());
  gst_buffer_pool_config_set_params(config, nullptr, kBytes, kBuffers, kBuffers);
  EXPECT_TRUE(gst_buffer_pool_set_config(pool.get(), config));
  EXPECT_TRUE(gst_buffer_pool_set_active(pool.get(), TRUE));
  std::vector<Ref<GstBuffer>> all;
  for (guint i = 0; i < kBuffers; ++i) {
    GstBuffer* buffer = nullptr;
    EXPECT_EQ(gst_buffer_pool_acquire_buffer(pool.get(), &buffer, nullptr), GST_FLOW_OK);
    gst_mini_object_set_qdata(GST_MINI_OBJECT_CAST(buffer), mark(), &buffer, nullptr);
    all.push_back(Ref<GstBuffer>::adopt(buffer));
  }
  return pool;
}

// How many of the pool's buffers are still the original ones.
guint marked_in(GstBufferPool* pool) {
  std::vector<Ref<GstBuffer>> all;
  guint marked = 0;
  for (guint i = 0; i < kBuffers; ++i) {
    GstBuffer* buffer = nullptr;
    EXPECT_EQ(gst_buffer_pool_acquire_buffer(pool, &buffer, nullptr), GST_FLOW_OK);
    marked += gst_mini_object_get_qdata(GST_MINI_OBJECT_CAST(buffer), mark()) ? 1 : 0;
    all.push_back(Ref<GstBuffer>::adopt(buffer));
  }
  return marked;
}

void run(const std::string& downstream, GstBufferPool* pool, int frames) {
  const auto pipeline = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_parse_launch(
      ("appsrc name=in format=time caps=\"" + std::string(kCaps) + "\" ! " + downstream).c_str(),
      nullptr))));
  const auto in = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "in"));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  for (int i = 0; i < frames; ++i) {
    GstBuffer* raw = nullptr;
    ASSERT_EQ(gst_buffer_pool_acquire_buffer(pool, &raw, nullptr), GST_FLOW_OK);
    GST_BUFFER_PTS(raw) = static_cast<GstClockTime>(i) * GST_SECOND / 30;
    // Ownership is passed on: GstBaseSrc would copy a buffer that is also held here to set its
    // flags.
    ASSERT_EQ(gst_app_src_push_buffer(GST_APP_SRC(in.get()), raw), GST_FLOW_OK);
  }
  EXPECT_EQ(gst_app_src_end_of_stream(GST_APP_SRC(in.get())), GST_FLOW_OK);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const Unique<GstMessage, gst_message_unref> message(gst_bus_timed_pop_filtered(
      bus.get(), GST_CLOCK_TIME_NONE, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  EXPECT_EQ(GST_MESSAGE_TYPE(message.get()), GST_MESSAGE_EOS);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

TEST(PoolReturn, SharedBuffersAreReused) {
  // A sink keeps its last buffer; queues keep buffers that others have released.
  const char* const lines[] = {
      "tensor_mux ! fakesink",
      "tensor_mux ! queue ! fakesink",
      "tensor_demux name=d d.src_0 ! queue ! fakesink",
      "tensor_split name=s tensorseg=6:1,6:3 s.src_0 ! queue ! fakesink s.src_1 ! queue ! fakesink",
      "tensor_mux ! tensor_demux name=d d.src_0 ! queue ! fakesink",
  };
  for (const char* line : lines) {
    const auto pool = marked_pool();
    run(line, pool.get(), 20);
    EXPECT_EQ(marked_in(pool.get()), kBuffers) << line;
    gst_buffer_pool_set_active(pool.get(), FALSE);
  }
}

TEST(PoolReturn, ABufferWhoseMemoryIsHeldIsNotReused) {
  const auto pool = marked_pool();
  const auto kept = Ref<GstBuffer>::adopt(gst_buffer_new());
  {
    GstBuffer* raw = nullptr;
    ASSERT_EQ(gst_buffer_pool_acquire_buffer(pool.get(), &raw, nullptr), GST_FLOW_OK);
    const auto buffer = Ref<GstBuffer>::adopt(raw);
    gst_buffer_append_memory(kept.get(), gst_buffer_get_memory(raw, 0));
  }
  EXPECT_EQ(marked_in(pool.get()), kBuffers - 1) << "marked buffers can be discarded";
  gst_buffer_pool_set_active(pool.get(), FALSE);
}

}  // namespace pool_return_test
}  // namespace weir::test
