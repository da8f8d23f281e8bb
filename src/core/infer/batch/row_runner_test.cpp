// Tests the parts of a batch: inputs, outputs and rejected batches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/row_runner.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <mutex>
#include <set>

namespace weir::infer {
namespace row_runner_test {

weir_tensor_info info_of(int64_t rows, int64_t width) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  info.rank = 2;
  info.shape[0] = rows;
  info.shape[1] = width;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

// x has 3 numbers per row; y has their sum.
struct Batch {
  explicit Batch(size_t rows) : x(3 * rows), y(rows, -1) {
    for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(i);
    set(&input, &x, info_of(static_cast<int64_t>(rows), 3));
    set(&output, &y, info_of(static_cast<int64_t>(rows), 1));
    in.n_tensors = out.n_tensors = 1;
    in.tensors = &input;
    out.tensors = &output;
  }
  static void set(weir_tensor* tensor, std::vector<float>* values, const weir_tensor_info& info) {
    tensor->data = values->data();
    tensor->bytes = tensor->capacity = values->size() * sizeof(float);
    tensor->info = info;
  }
  void expect_sums() const {
    for (size_t i = 0; i < y.size(); ++i) EXPECT_EQ(y[i], static_cast<float>(9 * i + 3)) << i;
  }
  std::vector<float> x, y;
  weir_tensor input{}, output{};
  weir_frame in{}, out{};
};

Result<bool> sum(const weir_frame& in, weir_frame& out) {
  const auto* x = static_cast<const float*>(in.tensors[0].data);
  auto* y = static_cast<float*>(out.tensors[0].data);
  for (int64_t i = 0; i < in.tensors[0].info.shape[0]; ++i)
    y[i] = x[3 * i] + x[3 * i + 1] + x[3 * i + 2];
  return true;
}

TEST(RowRunner, ReassemblesThePartsForEveryNumberOfRows) {
  for (const RowLimits limits :
       {RowLimits{4, 1}, RowLimits{0, 2}, RowLimits{3, 2}, RowLimits{1, 3}}) {
    RowRunner runner(limits);
    for (size_t rows = 1; rows < 30; ++rows) {
      Batch batch(rows);
      std::atomic<int64_t> seen = 0;
      const auto kept = runner.run(batch.in, batch.out, 1, [&](size_t, const auto& in, auto& out) {
        const int64_t count = in.tensors[0].info.shape[0];
        EXPECT_GE(count, 1);
        EXPECT_LE(count, static_cast<int64_t>(limits.rows ? limits.rows : rows));
        EXPECT_EQ(in.tensors[0].bytes, static_cast<uint64_t>(count) * 12);
        EXPECT_EQ(out.tensors[0].bytes, static_cast<uint64_t>(count) * 4);
        EXPECT_EQ(out.tensors[0].info.shape[0], count);
        seen += count;
        return sum(in, out);
      });
      ASSERT_TRUE(kept) << kept.error().message();
      EXPECT_TRUE(*kept);
      EXPECT_EQ(seen, static_cast<int64_t>(rows));
      batch.expect_sums();
    }
  }
}

TEST(RowRunner, SplitsEvenly) {
  RowRunner runner({32, 2});
  Batch batch(280);
  std::mutex mutex;
  std::multiset<int64_t> counts;
  const auto kept = runner.run(batch.in, batch.out, 1, [&](size_t, const auto& in, auto& out) {
    const std::lock_guard lock(mutex);
    counts.insert(in.tensors[0].info.shape[0]);
    return sum(in, out);
  });
  ASSERT_TRUE(kept);
  EXPECT_EQ(counts, (std::multiset<int64_t>{28, 28, 28, 28, 28, 28, 28, 28, 28, 28}));
}

// With 12 bytes per row, every fourth row begins at a multiple of 16.
TEST(RowRunner, KeepsTheAlignmentOfInputs) {
  RowRunner runner({5, 1});
  Batch batch(11);
  std::vector<std::ptrdiff_t> offsets;
  const auto kept = runner.run(batch.in, batch.out, 16, [&](size_t, const auto& in, auto& out) {
    offsets.push_back(static_cast<std::byte*>(in.tensors[0].data) -
                      reinterpret_cast<std::byte*>(batch.x.data()));
    return sum(in, out);
  });
  ASSERT_TRUE(kept);
  EXPECT_EQ(offsets, (std::vector<std::ptrdiff_t>{0, 48, 96}));
  batch.expect_sums();
}

TEST(RowRunner, GivesEachPartTheSourceMapsOfItsRows) {
  RowRunner runner({2, 1});
  Batch batch(5);
  std::vector<weir_source_map> maps(5);
  batch.in.maps = maps.data();
  batch.in.n_maps = 5;
  std::vector<std::ptrdiff_t> firsts;
  const auto kept = runner.run(batch.in, batch.out, 1, [&](size_t, const auto& in, auto& out) {
    EXPECT_EQ(in.n_maps, in.tensors[0].info.shape[0]);
    firsts.push_back(in.maps - maps.data());
    return sum(in, out);
  });
  ASSERT_TRUE(kept);
  EXPECT_EQ(firsts, (std::vector<std::ptrdiff_t>{0, 2, 4}));
}

TEST(RowRunner, ReportsTheFirstErrorAndDroppedFrames) {
  RowRunner runner({1, 1});
  Batch batch(4);
  const auto failed =
      runner.run(batch.in, batch.out, 1, [&](size_t, const auto& in, auto&) -> Result<bool> {
        const auto* x = static_cast<const float*>(in.tensors[0].data);
        if (x[0] < 6) return true;
        return Error{.code = Code::INVOKE_FAILED, .what = "row " + std::to_string(int(x[0]) / 3)};
      });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().what, "row 2");
  const auto dropped =
      runner.run(batch.in, batch.out, 1, [&](size_t, const auto& in, auto&) -> Result<bool> {
        return static_cast<const float*>(in.tensors[0].data)[0] != 3;
      });
  ASSERT_TRUE(dropped);
  EXPECT_FALSE(*dropped);
  const auto thrown =
      runner.run(batch.in, batch.out, 1,
                 [](size_t, const auto&, auto&) -> Result<bool> { throw std::bad_alloc(); });
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().code, Code::OUT_OF_MEMORY);
}

TEST(RowRunner, RejectsTensorsWithADifferentNumberOfRows) {
  RowRunner runner({2, 1});
  Batch batch(4);
  batch.output.info.shape[0] = 3;
  const auto never = [](size_t, const auto&, auto&) -> Result<bool> {
    ADD_FAILURE();
    return true;
  };
  const auto refused = runner.run(batch.in, batch.out, 1, never);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::BATCH_UNSUPPORTED);
  EXPECT_EQ(refused.error().offered, "a tensor that does not have 4 rows");
  EXPECT_EQ(refused.error().difference, "output 0");
  batch.in.n_tensors = 0;
  EXPECT_FALSE(runner.run(batch.in, batch.out, 1, never));
}

TEST(RowRunner, SplitsOnlyModelsWithAnOpenBatch) {
  const auto open = info_of(-1, 3);
  EXPECT_TRUE(check_rows(0, {open}, {open}));
  auto unknown = open;
  unknown.rank = WEIR_RANK_UNKNOWN;
  EXPECT_TRUE(check_rows(0, {open}, {unknown}));
  EXPECT_FALSE(check_rows(0, {unknown}, {open}));
  EXPECT_FALSE(check_rows(0, {}, {open}));
  EXPECT_FALSE(check_rows(WEIR_MODEL_STATEFUL, {open}, {open}));
  EXPECT_FALSE(check_rows(WEIR_MODEL_DYNAMIC_OUTPUT, {open}, {open}));
  auto inner = open;
  inner.batch_axis = 1;
  EXPECT_FALSE(check_rows(0, {inner}, {open}));
  const auto fixed = check_rows(0, {open}, {info_of(8, 3)});
  ASSERT_FALSE(fixed);
  EXPECT_EQ(fixed.error().code, Code::BATCH_UNSUPPORTED);
  EXPECT_EQ(fixed.error().offered, "8 rows");
  EXPECT_EQ(fixed.error().difference, "output 0");
}

}  // namespace row_runner_test
}  // namespace weir::infer
