// Test support for isolated models: the misbehaving engine of tests/support in a process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "core/isolate/isolated_engine.hpp"
#include "says.hpp"

namespace weir::isolate {

// Commands in the first byte of a frame, executed by unruly_engine.cpp.
enum Order : uint8_t {
  kNothing = 0,
  kCrash = 200,
  kAbort,
  kExit,
  kLoop,
  kEatMemory,
  kWriteInput,
  kSocket,
  kFork,
  kExec,
  kKillParent,
  kCloseSocket,
  kTalkNonsense,
  kFail,
  kDrop,
  kProcess,
  kKeepMemory,
  kSystemCall,
  kThreads,
  kGenerate,
  kVariable
};

using Bytes = std::vector<uint8_t>;

inline std::string model_file() {
  const std::string path = testing::TempDir() + "weir-isolated-" + std::to_string(getpid());
  std::ofstream(path) << "x";
  return path;
}

// One model in a worker process, one frame at a time.
class IsolatedTest : public ::testing::Test {
 protected:
  void SetUp() override {
    isolation_.engine = "unruly";
    isolation_.timeout = std::chrono::milliseconds(20000);
    isolation_.monitor = std::make_shared<Monitor>();
    isolation_.monitor->listen(
        [this](const Error& error) { reported_.push_back(error.message()); });
  }
  void TearDown() override {
    session_.reset();
    model_.reset();
    isolation_.monitor->listen({});
  }

  Status open(const std::string& key = "", const std::string& value = "") {
    infer::OpenOptions options;
    options.paths = {model_file()};
    if (!key.empty()) options.options = {{key, value}};
    options.host_context = std::make_shared<Isolation>(isolation_);
    auto model = infer::Model::open(isolated_engine(), options);
    if (!model) return model.error();
    model_ = *std::move(model);
    auto session = infer::Session::create(model_);
    if (!session) return session.error();
    session_ = *std::move(session);
    return ok();
  }
  std::string open_error(const std::string& value) {
    const Status status = open("open", value);
    return status ? "no error" : status.error().message();
  }

  static weir_tensor tensor(void* data, uint64_t bytes, uint32_t type, int64_t length) {
    weir_tensor out{};
    out.data = data;
    out.bytes = out.capacity = bytes;
    out.fence_fd = -1;
    out.info.type = type;
    out.info.rank = 1;
    out.info.shape[0] = length;
    return out;
  }
  static weir_frame frame(weir_tensor* tensor) {
    weir_frame out{};
    out.struct_size = sizeof out;
    out.n_tensors = 1;
    out.tensors = tensor;
    out.pts = out.duration = out.deadline = -1;
    return out;
  }

  // Fills result_. True: kept; false: dropped.
  Result<bool> run(const void* data, size_t bytes) { return run(*session_, data, bytes); }
  Result<bool> run(infer::Session& session, const void* data, size_t bytes) {
    auto in = tensor(const_cast<void*>(data), bytes, WEIR_UINT8, static_cast<int64_t>(bytes));
    auto out = tensor(&result_, sizeof result_, WEIR_UINT64, 1);
    const weir_frame in_frame = frame(&in);
    weir_frame out_frame = frame(&out);
    return session.invoke(in_frame, out_frame);
  }
  Result<bool> run(const Bytes& bytes) { return run(bytes.data(), bytes.size()); }
  // The result of a frame that must be kept.
  uint64_t result_of(const Bytes& bytes) {
    const auto kept = run(bytes);
    EXPECT_TRUE(kept && *kept) << (kept ? "dropped" : kept.error().message());
    return result_;
  }
  // Waits for the next worker.
  Status wait_for_worker() {
    const auto info = tensor(nullptr, 0, WEIR_UINT8, 4).info;
    const auto outputs = session_->resolve({info});
    return outputs ? ok() : Status(outputs.error());
  }
  MonitorCounts counts() const { return isolation_.monitor->counts(); }

  Isolation isolation_;
  std::shared_ptr<infer::Model> model_;
  std::unique_ptr<infer::Session> session_;
  uint64_t result_ = 0;
  std::vector<std::string> reported_;  // by the monitor
};

}  // namespace weir::isolate
