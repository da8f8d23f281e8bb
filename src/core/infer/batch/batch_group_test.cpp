// Tests that streams of the same shapes share a group, which ends with its last stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_group.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "core/infer/queue/numbered_job_test_support.hpp"

namespace weir::infer {
namespace batch_group_test {

using namespace std::chrono_literals;

weir_tensor_info row(int64_t length) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  info.rank = 2;
  info.shape[0] = 1;
  info.shape[1] = length;
  return info;
}
std::shared_ptr<BatchGroup> group(size_t batch_size, int64_t length) {
  return std::make_shared<BatchGroup>(
      BatchShapes{{{0}, {0}, false}, batch_size, {row(length)}, {row(length)}}, InputMemory{}, 0ns,
      [](const weir_frame& in, weir_frame& out, InvokeEnd*) -> Result<bool> {
        std::memcpy(out.tensors[0].data, in.tensors[0].data, in.tensors[0].bytes);
        return true;
      });
}

TEST(BatchGroup, TheSameShapesAndSizeAreOneGroup) {
  BatchGroups groups;
  int made = 0;
  const auto find = [&](size_t batch_size, int64_t length) {
    return *groups.find(batch_size, {row(length)}, [&]() -> Result<std::shared_ptr<BatchGroup>> {
      ++made;
      return group(batch_size, length);
    });
  };
  auto a = find(4, 2);
  EXPECT_EQ(find(4, 2), a);
  EXPECT_NE(find(4, 3), a) << "frames of another shape";
  EXPECT_NE(find(2, 2), a) << "another batch-size";
  EXPECT_EQ(made, 3);
  a.reset();
  find(4, 2);
  EXPECT_EQ(made, 4) << "it was not held";
}

TEST(BatchGroup, AFailedGroupReleasesEverything) {
  BatchGroups groups;
  const auto failed = groups.find(2, {row(2)}, [] {
    return Result<std::shared_ptr<BatchGroup>>(
        Error{.code = Code::BATCH_UNSUPPORTED, .what = "no"});
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().what, "no");
  EXPECT_TRUE(
      groups.find(2, {row(2)}, [] { return Result<std::shared_ptr<BatchGroup>>(group(2, 2)); }));
}

TEST(BatchGroup, AStreamKeepsItsGroupAndPassesItsFramesToIt) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<NumberedJob::End> ends;
  std::weak_ptr<BatchGroup> seen;
  {
    auto made = group(2, 2);
    seen = made;
    const auto stream = BatchGroup::join(made, 1h);
    made.reset();
    const auto note = [&](NumberedJob::End end) {
      std::lock_guard lock(mutex);
      ends.push_back(std::move(end));
      changed.notify_all();
    };
    stream->add(numbered(1, 5, note));
    stream->add(numbered(1, 6, note));
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ends.size() == 2; });
    EXPECT_FALSE(seen.expired());
  }
  EXPECT_TRUE(seen.expired());
  EXPECT_EQ(ends[1].outputs[0], (std::vector<float>{1, 6})) << "outlives the group";
}

}  // namespace batch_group_test
}  // namespace weir::infer
