// Test support: a job identified by stream and number that records how it ended.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <optional>
#include <ostream>
#include <span>

#include "core/infer/queue/batch_job.hpp"

namespace weir::infer {

struct Numbered {
  int stream, number;
  bool operator==(const Numbered&) const = default;
  friend std::ostream& operator<<(std::ostream& out, const Numbered& n) {
    return out << n.stream << "/" << n.number;
  }
};

// Its only input is the float32 tensor `values`. `ended` is called with the outputs' first bytes as
// floats, nullopt if dropped or failed.
class NumberedJob final : public BatchJob {
 public:
  struct End {
    Numbered job;
    std::vector<std::vector<float>> outputs;
    std::optional<Error> error;
    bool dropped = false;
    BatchRun run;
    uint64_t copied = 0;
    std::shared_ptr<void> owner;
    std::vector<const void*> places;
  };
  using Ended = std::function<void(End)>;

  NumberedJob(Numbered number, std::vector<float> values, Ended ended)
      : number_(number), values_(std::move(values)), ended_(std::move(ended)) {
    tensor_.data = values_.data();
    tensor_.bytes = tensor_.capacity = values_.size() * sizeof(float);
    tensor_.info.type = WEIR_FLOAT32;
  }
  const Numbered& number() const noexcept { return number_; }
  void expires_at(int64_t time) noexcept { expires_ = time; }
  std::span<const weir_tensor> inputs() const override { return {&tensor_, 1}; }
  int64_t expires() const override { return expires_; }
  void done(const BatchRun& run, std::span<const weir_tensor> outputs,
            const std::shared_ptr<void>& owner, uint64_t copied) override {
    End end{number_, {}, {}, false, run, copied, owner, {}};
    for (const auto& tensor : outputs) {
      const auto* at = static_cast<const float*>(tensor.data);
      end.outputs.emplace_back(at, at + tensor.bytes / sizeof *at);
      end.places.push_back(at);
    }
    if (ended_) ended_(std::move(end));
  }
  void failed(const Error& error) override {
    if (ended_) ended_({number_, {}, error, false, {}, 0, {}, {}});
  }
  void dropped(const BatchRun& run) override {
    if (ended_) ended_({number_, {}, {}, true, run, 0, {}, {}});
  }

 private:
  Numbered number_;
  std::vector<float> values_;
  Ended ended_;
  weir_tensor tensor_{};
  int64_t expires_ = 0;
};

inline std::unique_ptr<BatchJob> numbered(int stream, int number,
                                          NumberedJob::Ended ended = nullptr) {
  return std::make_unique<NumberedJob>(
      Numbered{stream, number},
      std::vector<float>{static_cast<float>(stream), static_cast<float>(number)}, std::move(ended));
}
inline Numbered number_of(const BatchJob& job) {
  return dynamic_cast<const NumberedJob&>(job).number();
}

}  // namespace weir::infer
