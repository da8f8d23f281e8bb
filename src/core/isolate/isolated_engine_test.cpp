// Tests that a model in a worker process behaves like one in this process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/isolated_engine.hpp"

#include <sys/wait.h>

#include <cerrno>
#include <numeric>

#include "core/isolate/isolated_test_support.hpp"

namespace weir::isolate {
namespace isolated_engine_test {

TEST_F(IsolatedTest, DescribesTheModelAsTheEngineDoes) {
  ASSERT_TRUE(open());
  EXPECT_EQ(engine_in(*model_), "unruly");
  ASSERT_EQ(model_->inputs().size(), 1u);
  EXPECT_STREQ(model_->inputs()[0].name, "bytes");
  EXPECT_EQ(model_->inputs()[0].type, uint32_t{WEIR_UINT8});
  EXPECT_EQ(model_->inputs()[0].shape[0], -1);
  ASSERT_EQ(model_->outputs().size(), 1u);
  EXPECT_STREQ(model_->outputs()[0].name, "result");
  EXPECT_EQ(model_->info().max_sessions, 0u) << "each session is a process: as many as wanted";
}

TEST_F(IsolatedTest, RunsFramesOfAnySize) {
  ASSERT_TRUE(open());
  for (const size_t size : {1, 7, 4096, 150528, 5000, 3000000}) {
    Bytes bytes(size, 3);
    bytes[0] = 0;
    EXPECT_EQ(result_of(bytes), 3 * (size - 1));
  }
  EXPECT_EQ(result_of({}), 0u);
  EXPECT_EQ(counts().ended, 0u);
}

TEST_F(IsolatedTest, ReadsFramesInSharedMemoryInPlace) {
  ASSERT_TRUE(open());
  const auto arena = get_arena(*model_);
  ASSERT_TRUE(arena);
  const auto block = arena->allocate(10000);
  ASSERT_TRUE(block);
  std::memset(block->data(), 0, 10000);
  for (int i = 1; i <= 10; ++i) {
    block->data()[500] = static_cast<std::byte>(i);
    ASSERT_TRUE(*run(block->data(), 10000));
    EXPECT_EQ(result_, static_cast<uint64_t>(i));
  }
  EXPECT_EQ(counts().bytes_copied, 10 * sizeof result_) << "the results only";
}

TEST_F(IsolatedTest, CopiesAndCountsFramesInOtherMemory) {
  ASSERT_TRUE(open());
  EXPECT_EQ(result_of({0, 1, 2}), 3u);
  EXPECT_EQ(counts().bytes_copied, 3 + sizeof result_);
}

TEST_F(IsolatedTest, ForgetsFreedBlocks) {
  ASSERT_TRUE(open());
  const auto arena = get_arena(*model_);
  for (size_t i = 1; i < 300; ++i) {  // each size is new, so no earlier block fits
    const auto block = arena->allocate(i * 8192);
    ASSERT_TRUE(block);
    block->data()[0] = std::byte{0};
    block->data()[1] = std::byte{2};
    ASSERT_TRUE(*run(block->data(), 2));
    EXPECT_EQ(result_, 2u);
  }
}

TEST_F(IsolatedTest, GivesOutputsThatTheEngineAllocates) {
  ASSERT_TRUE(open("output", "dynamic"));
  for (const size_t size : {1, 0, 100000, 4096, 20}) {
    Bytes bytes(size);
    std::iota(bytes.begin(), bytes.end(), uint8_t{0});
    auto in = tensor(bytes.data(), size, WEIR_UINT8, static_cast<int64_t>(size));
    auto out = tensor(nullptr, 0, WEIR_UINT8, -1);
    const weir_frame in_frame = frame(&in);
    weir_frame out_frame = frame(&out);
    const auto kept = session_->invoke(in_frame, out_frame);
    ASSERT_TRUE(kept && *kept) << (kept ? "dropped" : kept.error().message());
    ASSERT_EQ(out.bytes, size);
    EXPECT_EQ(out.info.shape[0], static_cast<int64_t>(size));
    for (size_t i = 0; i < size; ++i)
      ASSERT_EQ(static_cast<uint8_t*>(out.data)[i], static_cast<uint8_t>(i + 1));
    ASSERT_TRUE(out.release);
    out.release(out.owner);
  }
}

TEST_F(IsolatedTest, PassesOnTheEnginesError) {
  ASSERT_TRUE(open());
  const auto failed = run({kFail});
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, Code::INVOKE_FAILED);
  EXPECT_SAYS(failed.error().message(), "ordered to fail");
  EXPECT_SAYS(failed.error().message(), "fix: another frame");
  const auto dropped = run({kDrop});
  ASSERT_TRUE(dropped);
  EXPECT_FALSE(*dropped);
  EXPECT_EQ(result_of({0, 5}), 5u) << "the process lives on";
  EXPECT_EQ(counts().frames_lost, 0u) << "dropped by the model, not by an end";
  const auto control = session_->control(WEIR_WARM);
  ASSERT_FALSE(control);
  EXPECT_SAYS(control.error().message(), "the engine has no control function");
}

TEST_F(IsolatedTest, ReportsWhatIsWrongWithTheEngineOrTheModel) {
  isolation_.engine = "unrly";
  auto status = open();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::ENGINE_UNKNOWN);
  EXPECT_SAYS(status.error().message(), "did you mean unruly?");
  isolation_.engine = "";
  status = open();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::ENGINE_UNKNOWN);
  EXPECT_SAYS(status.error().message(), "no engine can be selected for this model");
}

TEST_F(IsolatedTest, HasAProcessForEachSession) {
  ASSERT_TRUE(open());
  auto other = infer::Session::create(model_);
  ASSERT_TRUE(other);
  const uint64_t first = result_of({kProcess});
  const Bytes ask{kProcess};
  ASSERT_TRUE(*run(**other, ask.data(), 1));
  EXPECT_NE(result_, first);
  EXPECT_NE(first, static_cast<uint64_t>(getpid()));
}

TEST_F(IsolatedTest, EndsEveryProcess) {
  ASSERT_TRUE(open());
  const auto id = static_cast<pid_t>(result_of({kProcess}));
  session_.reset();
  model_.reset();
  EXPECT_EQ(waitpid(id, nullptr, WNOHANG), -1) << "no zombie";
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace isolated_engine_test
}  // namespace weir::isolate
