// One case of `weir bench`: runs a model in this process on one engine, with a given thread count,
// frame by frame or in batches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>

#include "commands.hpp"
#include "core/infer/batch/batch_axis.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/module_library.hpp"
#include "doctor/engine_options.hpp"
#include "inspect/model_description.hpp"
#include "inspect/model_paths.hpp"
#include "inspect/synthetic_inputs.hpp"
#include "report.hpp"
#include "weir/module.hpp"

namespace weir::app {
namespace {

using Clock = std::chrono::steady_clock;
using Infos = std::vector<weir_tensor_info>;

constexpr int kWarmInvokes = 2, kMinInvokes = 3, kMaxInvokes = 200000;
constexpr double kKibibytesPerMebibyte = 1024;

double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

// Reads a field of /proc/self/status such as "VmHWM", in KiB.
double memory_of_process(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(field + ":")) return std::strtod(line.c_str() + field.size() + 1, nullptr);
  return 0;
}

struct MemoryUse {
  explicit MemoryUse(size_t bytes, size_t alignment, size_t padding)
      : data(std::aligned_alloc(alignment, ((bytes + padding) / alignment + 1) * alignment),
             std::free) {
    if (!data) throw std::bad_alloc();
  }
  std::unique_ptr<void, void (*)(void*)> data;
};

bool is_fixed(const weir_tensor_info& info) {
  return info.rank <= WEIR_RANK_LIMIT && info.type < WEIR_TYPE_END &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t n) { return n >= 0; });
}

// A session that repeatedly invokes one frame of made-up data.
class Case {
 public:
  static Result<std::unique_ptr<Case>> open(const BenchCaseOptions& options) {
    const auto engine = infer::ModuleLibrary::instance().engine(options.engine);
    if (!engine) return engine.error();
    infer::OpenOptions request;
    request.paths = split_paths(options.model);
    request.threads = options.threads;
    request.declared = options.tensors.pairs();
    request.options = custom_options(options.custom);
    auto model = infer::Model::open(**engine, request);
    if (!model) return model.error();
    auto session = infer::Session::create(*std::move(model));
    if (!session) return session.error();
    std::unique_ptr<Case> out(new Case(*std::move(session), options.tensors));
    if (auto status = out->prepare(static_cast<size_t>(options.batch)); !status)
      return status.error();
    return out;
  }

  const infer::Model& model() const { return session_->model(); }

  Status invoke() {
    for (size_t i = 0; i < outputs_.size(); ++i)
      if (open_[i]) outputs_[i] = weir_tensor{};
    const auto result = session_->invoke(in_, out_);
    for (size_t i = 0; i < outputs_.size(); ++i)
      if (open_[i] && outputs_[i].release) outputs_[i].release(outputs_[i].owner);
    if (!result) return result.error();
    return ok();
  }

 private:
  Case(std::unique_ptr<infer::Session> session, const TensorOptions& tensors)
      : session_(std::move(session)), tensors_(tensors) {}

  Result<Infos> inputs_of_batch(size_t batch) const {
    const auto& model = session_->model();
    if (batch == 1) return inputs_of_frame(model.inputs(), tensors_);
    const auto axes =
        infer::find_batch_axes(model.info().flags, model.inputs(), model.outputs(), batch);
    if (!axes) return axes.error();
    const auto frame = infer::of_one_frame(model.inputs(), axes->inputs, batch);
    auto chosen = inputs_of_frame(frame, tensors_);
    if (!chosen) return chosen.error();
    return infer::of_frames(*std::move(chosen), axes->inputs, batch);
  }

  Status prepare(size_t batch) {
    const auto infos = inputs_of_batch(batch);
    if (!infos) return infos.error();
    auto resolved = session_->resolve(*infos);
    if (!resolved) return resolved.error();
    std::mt19937 random(1);
    const auto& needs = session_->model().info();
    for (const auto& info : *infos) {
      add(&inputs_, info, std::max<uint32_t>(needs.alignment, kAlignment), needs.input_padding);
      inputs_.back().flags = WEIR_TENSOR_READONLY;
      fill_with_random_data(info, inputs_.back().data, random);
    }
    for (const auto& info : *resolved) {
      open_.push_back(!is_fixed(info));
      if (open_.back())
        outputs_.push_back({});
      else
        add(&outputs_, info, kAlignment, 0);
    }
    const auto make_frame = [](std::vector<weir_tensor>* tensors) {
      weir_frame frame{};
      frame.struct_size = sizeof frame;
      frame.n_tensors = static_cast<uint32_t>(tensors->size());
      frame.tensors = tensors->data();
      frame.pts = frame.duration = frame.deadline = -1;
      return frame;
    };
    in_ = make_frame(&inputs_);
    out_ = make_frame(&outputs_);
    return ok();
  }

  void add(std::vector<weir_tensor>* to, const weir_tensor_info& info, size_t alignment,
           size_t padding) {
    weir_tensor tensor{};
    tensor.info = info;
    tensor.bytes = count_bytes(info);
    tensor.capacity = tensor.bytes + padding;
    tensor.data = memory_.emplace_back(tensor.bytes, alignment, padding).data.get();
    to->push_back(tensor);
  }

  static constexpr uint32_t kAlignment = 64;
  std::unique_ptr<infer::Session> session_;
  const TensorOptions tensors_;
  std::vector<MemoryUse> memory_;
  std::vector<weir_tensor> inputs_, outputs_;
  std::vector<bool> open_;  // outputs that the engine allocates
  weir_frame in_{}, out_{};
};

std::string get_lowering(const infer::Model& model) {
  const Json metadata = model_description(model)["metadata"];
  const auto found = metadata.is_object() ? metadata.find("lowering") : metadata.end();
  return found != metadata.end() && found->is_string() ? found->get<std::string>() : "";
}

// {"ms", "load_ms", "mib", "lowering", "threads", "batch"}
Result<Json> measure(const BenchCaseOptions& options) {
  const double memory_before = memory_of_process("VmRSS");
  const auto start = Clock::now();
  const auto opened = Case::open(options);
  if (!opened) return opened.error();
  const double load = milliseconds(Clock::now() - start);
  for (int i = 0; i < kWarmInvokes; ++i)
    if (auto status = (*opened)->invoke(); !status) return status.error();
  std::vector<double> times;
  const auto begin = Clock::now();
  for (auto now = begin;
       times.size() < kMinInvokes ||
       (times.size() < kMaxInvokes && milliseconds(now - begin) < options.seconds * 1e3);) {
    if (auto status = (*opened)->invoke(); !status) return status.error();
    const auto after = Clock::now();
    times.push_back(milliseconds(after - now) / options.batch);
    now = after;
  }
  std::sort(times.begin(), times.end());
  const auto at = [&times](double part) {
    return times[static_cast<size_t>(part * static_cast<double>(times.size() - 1))];
  };
  constexpr double kTenth = 0.1;
  const double memory = memory_of_process("VmHWM") - memory_before;
  return Json{{"ms", times[times.size() / 2]},
              {"low_ms", at(kTenth)},
              {"high_ms", at(1 - kTenth)},
              {"load_ms", load},
              {"mib", std::max(memory, 0.0) / kKibibytesPerMebibyte},
              {"lowering", get_lowering((*opened)->model())},
              {"threads", options.threads},
              {"batch", options.batch}};
}

}  // namespace

int bench_case(const BenchCaseOptions& options) {
  const auto measured = measure(options);
  const std::string text = (measured ? *measured : Json{{"error", to_json(measured.error())}})
                               .dump(-1, ' ', false, Json::error_handler_t::replace);
  const bool written =
      write(options.descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  std::_Exit(written ? kExitGood : kExitError);  // skips exit handlers of engines, which may hang
}

}  // namespace weir::app
