// Deferred memory without an element: what works as with any memory, and what must fail.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/deferred_memory.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>
#include <vector>

namespace deferred_memory_test {

using weir::gst::DeferredCounts;
using weir::gst::MappedMemory;
using weir::gst::Ref;
using Bytes = std::vector<std::byte>;
using Memory = Ref<GstMemory>;

Ref<GstBuffer> buffer_of(const Bytes& bytes) {
  GstBuffer* buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
  return Ref<GstBuffer>::adopt(buffer);
}
Bytes bytes_of(GstMemory* memory) {
  const MappedMemory map(memory, GST_MAP_READ);
  EXPECT_TRUE(map);
  return {map.bytes().begin(), map.bytes().end()};
}
Bytes bytes_of(const Ref<GstBuffer>& buffer) {
  EXPECT_EQ(gst_buffer_n_memory(buffer.get()), 1u);
  return bytes_of(gst_buffer_peek_memory(buffer.get(), 0));
}

class DeferredMemory : public testing::Test {
 protected:
  static constexpr size_t kCount = 1000;

  Memory make(Ref<GstBuffer> buffer) const {
    return Memory::adopt(weir::gst::make_deferred_memory({std::move(buffer), 0, plan_}, counts_));
  }
  Memory make() const { return make(buffer_of(in_)); }
  uint64_t computed() const { return counts_->computed; }

  Bytes in_ = Bytes(kCount, std::byte{5}), expected_ = Bytes(kCount, std::byte{12});
  std::shared_ptr<const weir::transform::TransformPlan> plan_ = [] {
    const auto operation = weir::transform::parse(weir::transform::Mode::Arithmetic, "add:7,div:0");
    return std::make_shared<const weir::transform::TransformPlan>(
        *weir::transform::plan(*operation, {weir::ElementType::UInt8, {kCount}, ""}, true));
  }();
  std::shared_ptr<DeferredCounts> counts_ = std::make_shared<DeferredCounts>();
};

TEST_F(DeferredMemory, IsComputedOnceWhenItIsMapped) {
  const auto memory = make();
  EXPECT_EQ(computed(), 0u);
  EXPECT_TRUE(weir::gst::deferred_source(memory.get()));
  EXPECT_EQ(bytes_of(memory.get()), expected_);
  EXPECT_EQ(bytes_of(memory.get()), expected_);
  EXPECT_EQ(computed(), 1u);
  EXPECT_EQ(counts_->divisions_by_zero, kCount);
  EXPECT_FALSE(weir::gst::deferred_source(memory.get()));
}

TEST_F(DeferredMemory, IsComputedOnceByManyThreads) {
  const auto memory = make();
  std::vector<std::thread> threads;
  std::vector<Bytes> seen(8);
  for (auto& bytes : seen) threads.emplace_back([&] { bytes = bytes_of(memory.get()); });
  for (auto& thread : threads) thread.join();
  for (const auto& bytes : seen) EXPECT_EQ(bytes, expected_);
  EXPECT_EQ(computed(), 1u);
}

TEST_F(DeferredMemory, ReleasesItsSourceWhenComputed) {
  auto source = buffer_of(in_);
  const auto memory = make(source);
  EXPECT_EQ(GST_MINI_OBJECT_REFCOUNT_VALUE(source.get()), 2);
  bytes_of(memory.get());
  EXPECT_EQ(GST_MINI_OBJECT_REFCOUNT_VALUE(source.get()), 1);
}

TEST_F(DeferredMemory, OfDeferredMemoryIsComputedThroughBoth) {
  auto between = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(between.get(), make().release());
  EXPECT_EQ(bytes_of(make(between).get()), Bytes(kCount, std::byte{19}));
  EXPECT_EQ(computed(), 2u);
}

TEST_F(DeferredMemory, KeepsWrittenBytes) {
  const auto memory = make();
  {
    const MappedMemory map(memory.get(), GST_MAP_READWRITE);
    ASSERT_TRUE(map);
    EXPECT_EQ(map.bytes()[1], std::byte{12});
    map.bytes()[0] = std::byte{99};
  }
  auto expected = expected_;
  expected[0] = std::byte{99};
  EXPECT_EQ(bytes_of(memory.get()), expected);
}

TEST_F(DeferredMemory, IsNotASourceOnceResized) {
  const auto memory = make();
  gst_memory_resize(memory.get(), 10, 100);
  EXPECT_FALSE(weir::gst::deferred_source(memory.get()));
  EXPECT_EQ(bytes_of(memory.get()), Bytes(100, std::byte{12}));
}

TEST_F(DeferredMemory, ItsCopyIsSystemMemory) {
  const auto memory = make();
  const auto copy = Memory::adopt(gst_memory_copy(memory.get(), 10, 20));
  EXPECT_TRUE(gst_memory_is_type(copy.get(), GST_ALLOCATOR_SYSMEM));
  EXPECT_EQ(bytes_of(copy.get()), Bytes(20, std::byte{12}));
}

TEST_F(DeferredMemory, APartOutlivesTheWhole) {
  auto memory = make();
  auto part = Memory::adopt(gst_memory_share(memory.get(), 990, 10));
  const auto rest = Memory::adopt(gst_memory_share(memory.get(), 995, -1));
  memory = {};
  EXPECT_EQ(bytes_of(part.get()), Bytes(10, std::byte{12}));
  EXPECT_EQ(bytes_of(rest.get()), Bytes(5, std::byte{12}));
  EXPECT_FALSE(MappedMemory(part.get(), GST_MAP_WRITE)) << "it is shared";
}

TEST_F(DeferredMemory, APartOfABufferIsSharedAsUsual) {
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(buffer.get(), make().release());
  const auto part =
      Ref<GstBuffer>::adopt(gst_buffer_copy_region(buffer.get(), GST_BUFFER_COPY_MEMORY, 1, 3));
  EXPECT_EQ(bytes_of(part), Bytes(3, std::byte{12}));
  const auto deep = Ref<GstBuffer>::adopt(gst_buffer_copy_deep(buffer.get()));
  EXPECT_EQ(bytes_of(deep), expected_);
}

TEST_F(DeferredMemory, CannotBeMappedWhenItsSourceIsTooSmall) {
  const auto memory = make(buffer_of(Bytes(kCount - 1)));
  EXPECT_FALSE(MappedMemory(memory.get(), GST_MAP_READ));
  EXPECT_FALSE(MappedMemory(memory.get(), GST_MAP_READ)) << "also on the second attempt";
  EXPECT_EQ(computed(), 0u);
}

TEST_F(DeferredMemory, CannotBeMappedWhileItsSourceIsBeingWritten) {
  auto source = buffer_of(in_);
  const auto memory = make(source);
  {
    const MappedMemory writing(gst_buffer_peek_memory(source.get(), 0), GST_MAP_WRITE);
    EXPECT_FALSE(MappedMemory(memory.get(), GST_MAP_READ));
  }
  EXPECT_EQ(bytes_of(memory.get()), expected_);
}

TEST_F(DeferredMemory, OtherMemoryIsNotDeferred) {
  const auto other = Memory::adopt(gst_allocator_alloc(nullptr, 10, nullptr));
  EXPECT_FALSE(weir::gst::is_deferred_memory(other.get()));
  EXPECT_FALSE(weir::gst::deferred_source(other.get()));
}

struct Pads {
  GstPad* source = gst_pad_new("source", GST_PAD_SRC);
  GstPad* sink = gst_pad_new("sink", GST_PAD_SINK);
  GstPad* other = gst_pad_new("other", GST_PAD_SINK);
  Pads() { gst_pad_link(source, sink); }
  ~Pads() {
    for (GstPad* pad : {source, sink, other}) gst_object_unref(pad);
  }
};

TEST(DeferralOffer, IsValidOnlyFromTheLinkedPad) {
  const Pads pads;
  const auto query = Ref<GstQuery>::adopt(gst_query_new_allocation(nullptr, FALSE));
  EXPECT_FALSE(weir::gst::deferral_is_offered(query.get(), pads.source));
  weir::gst::offer_deferral(query.get(), pads.other);
  EXPECT_FALSE(weir::gst::deferral_is_offered(query.get(), pads.source));
  weir::gst::offer_deferral(query.get(), pads.sink);
  EXPECT_TRUE(weir::gst::deferral_is_offered(query.get(), pads.source));
  gst_pad_unlink(pads.source, pads.sink);
  EXPECT_FALSE(weir::gst::deferral_is_offered(query.get(), pads.source));
}

}  // namespace deferred_memory_test
