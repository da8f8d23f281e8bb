// Tests shared memory: seals, locations, reuse.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/shared_arena.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cerrno>
#include <set>

#include "says.hpp"

namespace weir::isolate {
namespace shared_arena_test {

constexpr size_t kPage = SharedBlock::kPage;

TEST(SharedBlock, CannotBeWrittenThroughTheDescriptor) {
  const auto block = SharedBlock::create(100, Sharing::ReadByWorker);
  ASSERT_TRUE(block);
  (*block)->data()[5] = std::byte{42};
  EXPECT_FALSE(Mapping((*block)->descriptor(), kPage, true));
  const Mapping reader((*block)->descriptor(), kPage, false);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader.data()[5], std::byte{42});
}

TEST(SharedBlock, CannotBeShortened) {
  for (const auto sharing : {Sharing::ReadByWorker, Sharing::WrittenByWorker}) {
    const auto block = SharedBlock::create(3 * kPage, sharing);
    ASSERT_TRUE(block);
    EXPECT_EQ(ftruncate((*block)->descriptor(), 0), -1);
    EXPECT_EQ(errno, EPERM);
    EXPECT_EQ(ftruncate((*block)->descriptor(), 8 * kPage), -1);
  }
}

TEST(SharedBlock, OfResultsIsWrittenByTheWorker) {
  const auto block = SharedBlock::create(1, Sharing::WrittenByWorker);
  ASSERT_TRUE(block);
  const Mapping writer((*block)->descriptor(), kPage, true);
  ASSERT_TRUE(writer);
  writer.data()[7] = std::byte{9};
  EXPECT_EQ((*block)->data()[7], std::byte{9});
}

TEST(SharedBlock, ReportsMemoryThatCannotBeAllocated) {
  const auto block = SharedBlock::create(SIZE_MAX, Sharing::ReadByWorker);
  ASSERT_FALSE(block);
  EXPECT_EQ(block.error().code, Code::OUT_OF_MEMORY);
  EXPECT_SAYS(block.error().message(), "no shared memory for a worker process");
}

TEST(SharedArena, KnowsWhichBlockContainsAnAddress) {
  const auto arena = SharedArena::make(0);
  const auto a = arena->allocate(kPage), b = arena->allocate(2 * kPage);
  ASSERT_TRUE(a && b);
  const auto place = arena->find(b->data() + 100, kPage);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->block->id(), b->id());
  EXPECT_EQ(place->offset, 100u);
  EXPECT_EQ(place->capacity, 2 * kPage - 100);
  EXPECT_FALSE(arena->find(b->data() + 100, 2 * kPage)) << "more than there is";
  EXPECT_TRUE(arena->find(a->data(), kPage));
  const int elsewhere = 0;
  EXPECT_FALSE(arena->find(&elsewhere, sizeof elsewhere));
  EXPECT_FALSE(arena->find(nullptr, 0));
}

TEST(SharedArena, PadsEachFrame) {
  const auto arena = SharedArena::make(64);
  EXPECT_EQ(arena->allocate(kPage - 64)->bytes(), kPage);
  EXPECT_EQ(arena->allocate(kPage)->bytes(), 2 * kPage);
}

TEST(SharedArena, ReusesReturnedBlocks) {
  const auto arena = SharedArena::make(0);
  const uint64_t id = arena->allocate(kPage)->id();
  EXPECT_EQ(arena->allocate(kPage)->id(), id);
  EXPECT_NE(arena->allocate(64 * kPage)->id(), id) << "too small";
  EXPECT_NE(arena->allocate(0)->id(), 0u);
}

TEST(SharedArena, IsLimited) {
  const auto arena = SharedArena::make(0);
  std::vector<std::shared_ptr<SharedBlock>> held;
  for (size_t i = 0; i < SharedArena::kMaxBlocks; ++i) held.push_back(arena->allocate(1));
  EXPECT_TRUE(held.back());
  EXPECT_FALSE(arena->allocate(1));
  held.pop_back();
  EXPECT_TRUE(arena->allocate(1));
  EXPECT_FALSE(arena->allocate(SIZE_MAX));
}

TEST(SharedArena, KeepsALimitedAmountOfReturnedBlocks) {
  const auto arena = SharedArena::make(0);
  std::vector<std::shared_ptr<SharedBlock>> held;
  std::set<uint64_t> before;
  for (size_t i = 0; i < 2 * SharedArena::kRetained; ++i) {
    held.push_back(arena->allocate(1));
    before.insert(held.back()->id());
  }
  held.clear();
  size_t again = 0;
  for (size_t i = 0; i < 2 * SharedArena::kRetained; ++i) {
    held.push_back(arena->allocate(1));
    again += before.count(held.back()->id());
  }
  EXPECT_EQ(again, SharedArena::kRetained);
}

TEST(SharedArena, LivesAsLongAsItsLastFrame) {
  auto arena = SharedArena::make(0);
  const auto frame = arena->allocate(1);
  const std::weak_ptr<SharedArena> watched = arena;
  arena.reset();
  EXPECT_FALSE(watched.expired());
  frame->data()[0] = std::byte{1};
}

}  // namespace shared_arena_test
}  // namespace weir::isolate
