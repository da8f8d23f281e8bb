// Tests that the parts of a frame become memories in order, and that those beyond 16 share one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_builder.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "gstcpp/buffer/allocation.hpp"

namespace weir::gst {
namespace frame_builder_test {

using Bytes = std::vector<std::byte>;

class BufferParts : public testing::Test {
 protected:
  // A part with `size` bytes of `value`, in a memory of its own or as bytes to copy.
  void add(uint8_t value, size_t size, bool in_memory) {
    bytes_.push_back(Bytes(size, std::byte{value}));
    if (!in_memory) return parts_.push_back({{}, bytes_.back()});
    auto memory = *allocate_memory(size);
    const MappedMemory map(memory.get(), GST_MAP_WRITE);
    std::copy(bytes_.back().begin(), bytes_.back().end(), map.bytes().begin());
    parts_.push_back({memory, {}});
  }
  Status append() {
    return append_parts(parts_, out_.get(), [this](size_t bytes) {
      allocated_.push_back(bytes);
      return allocate_memory(bytes);
    });
  }
  Bytes content() const {
    Bytes out(gst_buffer_get_size(out_.get()));
    gst_buffer_extract(out_.get(), 0, out.data(), out.size());
    return out;
  }
  Bytes expected() const {
    Bytes out;
    for (const auto& bytes : bytes_) out.insert(out.end(), bytes.begin(), bytes.end());
    return out;
  }
  guint memories() const { return gst_buffer_n_memory(out_.get()); }

  std::vector<Bytes> bytes_;
  std::vector<BufferPart> parts_;
  std::vector<size_t> allocated_;
  Ref<GstBuffer> out_ = Ref<GstBuffer>::adopt(gst_buffer_new());
};

TEST_F(BufferParts, AreSharedWhereTheyAreMemories) {
  add(1, 3, true);
  add(2, 5, true);
  ASSERT_TRUE(append());
  EXPECT_EQ(memories(), 2u);
  EXPECT_EQ(gst_buffer_peek_memory(out_.get(), 0), parts_[0].memory.get());
  EXPECT_TRUE(allocated_.empty());
  EXPECT_EQ(content(), expected());
}

TEST_F(BufferParts, AreCopiedWhereTheyAreBytes) {
  add(1, 3, true);
  add(2, 5, false);
  ASSERT_TRUE(append());
  EXPECT_EQ(allocated_, std::vector<size_t>{5});
  EXPECT_EQ(content(), expected());
}

TEST_F(BufferParts, Of16AreAMemoryEach) {
  for (uint8_t i = 0; i < 16; ++i) add(i, i + 1u, true);
  ASSERT_TRUE(append());
  EXPECT_EQ(memories(), 16u);
  EXPECT_TRUE(allocated_.empty());
  EXPECT_EQ(content(), expected());
}

TEST_F(BufferParts, Beyond16ShareTheLastMemory) {
  for (uint8_t i = 0; i < 40; ++i) add(i, i + 1u, i % 2 == 0);
  ASSERT_TRUE(append());
  EXPECT_EQ(memories(), 16u);
  EXPECT_EQ(allocated_.size(), 7u + 1) << "seven parts of bytes among the first 15, and the rest";
  EXPECT_EQ(content(), expected());
}

TEST_F(BufferParts, FailWhereNoMemoryCanBeAllocated) {
  add(1, 3, false);
  const auto status = append_parts(parts_, out_.get(), [](size_t) -> Result<Ref<GstMemory>> {
    return Error{.code = Code::OUT_OF_MEMORY, .what = "no memory"};
  });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::OUT_OF_MEMORY);
  EXPECT_EQ(memories(), 0u);
}

}  // namespace frame_builder_test
}  // namespace weir::gst
