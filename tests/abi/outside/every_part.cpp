// A third-party engine in C++ that uses every part of the interface. In: float32 of any length.
// Out: "scaled", the input times `factor`; "positive", all values above 0.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <weir/engine.hpp>
#include <weir/source_map.hpp>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

namespace {

using weir::Code;
using weir::Failure;

class EveryPart {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL | WEIR_ENGINE_MODEL_IS_NO_FILE;
  static constexpr const char* kOptions = R"([
    {"name": "factor", "type": "number", "default": "1", "help": "what the input is multiplied with"},
    {"name": "repeat", "type": "integer", "default": "1", "help": "outputs per input, asynchronous"},
    {"name": "rest", "type": "integer", "default": "0", "help": "seconds that an asynchronous answer takes"}])";

  explicit EveryPart(const weir::OpenRequest& request) {
    factor_ = number(request.options, "factor", 1);
    repeat_ = static_cast<int>(number(request.options, "repeat", 1));
    rest_ = std::chrono::seconds(static_cast<int>(number(request.options, "rest", 0)));
  }
  ~EveryPart() {
    for (auto& thread : threads_) thread.join();
  }
  std::span<const weir_tensor_info> inputs() const { return {&input_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return outputs_; }
  void describe(weir_model_info& info) const {
    info.flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
    info.alignment = 64;
    info.input_padding = 32;
    info.weight_bytes = 4;
    info.metadata_json = R"({"author": "another author"})";
  }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    out[0].shape[0] = in[0].shape[0];
  }

  bool invoke(const weir_frame& in, weir_frame& out) {
    if (elements(in).size() == 1) return false;  // drops the frame
    make(in, {out.tensors, out.n_tensors}, factor_);
    return true;
  }
  void submit(const weir_frame& in, weir::Request& request) {
    check(in);
    threads_.emplace_back([this, &in, kept = std::move(request)]() mutable {
      try {
        if (rest_.count() > 0) rest(kept.id());
        for (int i = 0; i < repeat_ && !kept.cancelled(); ++i) {
          weir_tensor tensors[2] = {};
          make(in, tensors, factor_ + static_cast<float>(i));
          kept.output(tensors);
        }
        kept.end();
      } catch (const Failure& failure) {
        kept.fail(failure.error());
      }
    });
  }
  void cancel(const weir_request* request) {
    {
      std::lock_guard lock(mutex_);
      cancelled_ = request;
      changed_.notify_all();
    }
    weir::module_host->log(WEIR_LOG_WARNING, "outside-cpp", "cancel() was called");
  }
  void control(int op, const weir_option* option) {
    if (op == WEIR_SET_OPTION && option && std::strcmp(option->key, "factor") == 0)
      factor_ = std::strtof(option->value, nullptr);
    else if (op != WEIR_WARM)
      throw Failure({.code = Code::OPTION_VALUE,
                     .what = "this engine has no such control",
                     .offered = std::to_string(op)});
  }

 private:
  // A long computation that cancel() ends.
  void rest(const weir_request* request) {
    weir::module_host->log(WEIR_LOG_WARNING, "outside-cpp", "a request rests");
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, rest_, [&] { return cancelled_ == request; });
  }
  static float number(const weir::Options& options, const char* key, float otherwise) {
    const auto text = options.get(key);
    if (!text) return otherwise;
    char* end = nullptr;
    const std::string copy(*text);
    const float value = std::strtof(copy.c_str(), &end);
    if (copy.empty() || *end)
      throw Failure({.code = Code::OPTION_VALUE,
                     .what = "an option is no number",
                     .offered = std::string(key) + ":" + copy,
                     .needed = "a number",
                     .fix = "custom=factor:2.5"});
    return value;
  }
  static std::span<const float> elements(const weir_frame& in) {
    return weir::elements<const float>(in.tensors[0]);
  }
  void check(const weir_frame& in) const {
    const auto& tensor = in.tensors[0];
    if (reinterpret_cast<uintptr_t>(tensor.data) % 64 != 0 || tensor.capacity < tensor.bytes + 32)
      throw Failure({.code = Code::INTERNAL, .what = "the requirements for memory were not met"});
    for (const float x : elements(in))
      if (std::isnan(x))
        throw Failure({.code = Code::INVOKE_FAILED,
                       .what = "a value is not a number",
                       .offered = "NaN",
                       .needed = "numbers",
                       .difference = "the first NaN",
                       .fix = "clean the input"});
  }
  // Writes into memory that is given, and allocates it otherwise.
  void make(const weir_frame& in, std::span<weir_tensor> out, float factor) const {
    check(in);
    const auto x = elements(in);
    const auto room = [&](weir_tensor& tensor, const weir_tensor_info& info, size_t count) {
      if (tensor.data) return;
      weir_tensor_info exact = info;
      exact.shape[0] = static_cast<int64_t>(count);
      weir::allocate(&tensor, exact, count * sizeof(float));
    };
    room(out[0], outputs_[0], x.size());
    const auto scaled = weir::elements<float>(out[0]);
    std::vector<float> positive;
    for (size_t i = 0; i < x.size(); ++i) {
      scaled[i] = factor * x[i];
      if (x[i] > 0) positive.push_back(x[i]);
    }
    room(out[1], outputs_[1], positive.size());
    if (!positive.empty())
      std::memcpy(out[1].data, positive.data(), positive.size() * sizeof(float));
  }

  float factor_ = 1;
  int repeat_ = 1;
  std::chrono::seconds rest_{0};
  std::mutex mutex_;  // guards cancelled_
  std::condition_variable changed_;
  const weir_request* cancelled_ = nullptr;  // the last cancelled request
  std::vector<std::thread> threads_;
  weir_tensor_info input_ = weir::tensor_info("x", WEIR_FLOAT32, {-1});
  std::vector<weir_tensor_info> outputs_{weir::tensor_info("scaled", WEIR_FLOAT32, {-1}),
                                         weir::tensor_info("positive", WEIR_FLOAT32, {-1})};
};

}  // namespace

WEIR_ENGINE(EveryPart, "outside-cpp", "1.0", "outside", "")
