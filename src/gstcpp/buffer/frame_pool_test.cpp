// Tests the output buffers of a stream: their memories and headers, what the pool retains, limits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_pool.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "says.hpp"

namespace weir::gst {
namespace frame_pool_test {

std::vector<TensorSpec> bytes_of_sizes(const std::vector<uint32_t>& sizes) {
  std::vector<TensorSpec> out;
  for (const uint32_t size : sizes) out.push_back({ElementType::UInt8, {size}, ""});
  return out;
}
FramePool pool_of(const std::vector<uint32_t>& sizes, Format format = Format::Static,
                  size_t retain = 8) {
  auto pool = FramePool::make(bytes_of_sizes(sizes), format, MediaType::Tensor, {}, retain);
  EXPECT_TRUE(pool) << pool.error().message();
  return *std::move(pool);
}
size_t size_of_memory(const Ref<GstBuffer>& buffer, guint i) {
  return gst_memory_get_sizes(gst_buffer_peek_memory(buffer.get(), i), nullptr, nullptr);
}

TEST(FramePool, GivesEachTensorAMemory) {
  FramePool pool = pool_of({5, 7});
  const auto buffer = *pool.acquire();
  ASSERT_EQ(gst_buffer_n_memory(buffer.get()), 2u);
  EXPECT_EQ(size_of_memory(buffer, 0), 5u);
  EXPECT_EQ(size_of_memory(buffer, 1), 7u);
}

TEST(FramePool, WritesTheHeadersOfFlexibleTensors) {
  FramePool pool = pool_of({5}, Format::Flexible);
  const auto buffer = *pool.acquire();
  FramePool::Writer writer;
  ASSERT_TRUE(writer.map(pool, buffer.get()));
  ASSERT_EQ(writer.payloads().size(), 1u);
  EXPECT_EQ(writer.payloads()[0].size(), 5u);
  std::memset(writer.payloads()[0].data(), 9, 5);
  writer.unmap();
  std::vector<std::byte> all(gst_buffer_get_size(buffer.get()));
  gst_buffer_extract(buffer.get(), 0, all.data(), all.size());
  ASSERT_EQ(all.size(), kTensorHeaderBytes + 5);
  const auto header = read_tensor_header(all);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->spec.to_string(), "uint8 5");
  EXPECT_EQ(all.back(), std::byte{9});
}

TEST(FramePool, PacksTheTensorsFromThe16thOn) {
  FramePool pool = pool_of(std::vector<uint32_t>(20, 3));
  const auto buffer = *pool.acquire();
  EXPECT_EQ(gst_buffer_n_memory(buffer.get()), 16u);
  EXPECT_EQ(size_of_memory(buffer, 15), kPackedHeaderBytes + 5 * 3);
  FramePool::Writer writer;
  ASSERT_TRUE(writer.map(pool, buffer.get()));
  ASSERT_EQ(writer.payloads().size(), 20u);
  for (const auto& payload : writer.payloads()) EXPECT_EQ(payload.size(), 3u);
}

TEST(FramePool, ReusesBuffersUpToALimit) {
  FramePool pool = pool_of({64}, Format::Static, 2);
  for (int round = 0; round < 3; ++round) {
    const auto a = *pool.acquire(), b = *pool.acquire(), c = *pool.acquire();
    EXPECT_EQ(pool.stats().retained, 0u);
  }
  EXPECT_EQ(pool.stats().retained, 2u);
  EXPECT_EQ(pool.stats().allocated, 3u + 1 + 1) << "one of three is allocated in each later round";
}

TEST(FramePool, RestoresTheLengthOfAShortenedBuffer) {
  FramePool pool = pool_of({64});
  gst_buffer_resize((*pool.acquire()).get(), 0, 10);
  const auto again = *pool.acquire();
  EXPECT_EQ(gst_buffer_get_size(again.get()), 64u);
  EXPECT_EQ(pool.stats().allocated, 1u);
}

TEST(FramePool, DoesNotReuseAMemoryThatIsStillInUse) {
  FramePool pool = pool_of({64});
  const auto user = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(user.get(), gst_buffer_get_memory((*pool.acquire()).get(), 0));
  const auto other = *pool.acquire();
  EXPECT_NE(gst_buffer_peek_memory(other.get(), 0), gst_buffer_peek_memory(user.get(), 0));
  EXPECT_EQ(pool.stats().allocated, 2u);
}

// As a callback that maps a frame and forgets to unmap it.
TEST(FramePool, DoesNotReuseAMemoryThatIsStillMapped) {
  for (const auto flags : {GST_MAP_READ, GST_MAP_WRITE, GST_MAP_READWRITE}) {
    FramePool pool = pool_of({64});
    for (int i = 0; i < 3; ++i) {
      GstMapInfo forgotten = GST_MAP_INFO_INIT;
      {
        const auto buffer = *pool.acquire();
        FramePool::Writer writer;
        ASSERT_TRUE(writer.map(pool, buffer.get())) << "frame " << i;
        writer.unmap();
        ASSERT_TRUE(gst_buffer_map(buffer.get(), &forgotten, flags));
      }
      EXPECT_EQ(pool.stats().retained, 0u);
      gst_memory_unmap(forgotten.memory, &forgotten);
      gst_memory_unref(forgotten.memory);
    }
  }
}

TEST(FramePool, RejectsABufferAboveTheLimit) {
  FramePool pool = pool_of({64});
  BufferLimit limit("tensor_test");
  limit.set_bytes(63);
  const auto refused = pool.acquire(limit);
  ASSERT_FALSE(refused);
  EXPECT_SAYS(refused.error().message(), "fix: tensor_test max-buffer-size=64");
  limit.set_bytes(64);
  EXPECT_TRUE(pool.acquire(limit));
  EXPECT_EQ(pool.stats().allocated, 1u) << "the rejected one was not allocated";
}

TEST(FramePool, CannotBeMadeForTensorsThatAFrameCannotHold) {
  EXPECT_SAYS(FramePool::make({}, Format::Static).error().message(), "too few or too many tensors");
  const auto many = FramePool::make(bytes_of_sizes(std::vector<uint32_t>(257, 1)), Format::Static);
  EXPECT_SAYS(many.error().message(), "offered: 257");
  const auto huge =
      FramePool::make({{ElementType::Float64, {1u << 31, 1u << 20}, ""}}, Format::Static);
  EXPECT_SAYS(huge.error().message(), "needed: at most 1 TiB");
}

TEST(FramePool, RejectsABufferThatCannotBeWritten) {
  FramePool pool = pool_of({8});
  const auto readonly = Ref<GstBuffer>::adopt(gst_buffer_new());
  static const char kBytes[8] = {};
  gst_buffer_append_memory(
      readonly.get(), gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, const_cast<char*>(kBytes), 8,
                                             0, 8, nullptr, nullptr));
  FramePool::Writer writer;
  EXPECT_FALSE(writer.map(pool, readonly.get()));
  const auto empty = Ref<GstBuffer>::adopt(gst_buffer_new());
  EXPECT_FALSE(writer.map(pool, empty.get()));
}

}  // namespace frame_pool_test
}  // namespace weir::gst
