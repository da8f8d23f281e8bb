// Serialisation, shapes, and the two ways to invoke: on this thread, or on one with a time limit.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/direct_model.hpp"

#include <condition_variable>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/direct/inputs.hpp"
#include "core/direct/results.hpp"
#include "core/direct/tensor_text.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "core/timer/deadline.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::direct {
namespace {

struct Batch {
  std::vector<weir_tensor_info> infos;  // with the frames in axis 0
  Results memory;
};

Error unsupported(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::BATCH_UNSUPPORTED,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "invoke the frames one by one"};
}

// Checks that axis 0 of this input can hold the frames.
Status check_axis(const weir_tensor_info& info, uint32_t frames, size_t index) {
  const uint32_t axis = info.batch_axis == WEIR_NO_BATCH_AXIS ? 0 : info.batch_axis;
  const bool free = info.rank <= WEIR_RANK_LIMIT && info.rank > 0 && axis == 0 &&
                    (info.shape[0] < 0 || info.shape[0] == frames);
  if (free) return ok();
  return unsupported(
      place_text("input", index, info) + " cannot hold " + std::to_string(frames) + " frames",
      to_string(info), "a free axis 0");
}

// The current shapes for one frame.
std::vector<weir_tensor_info> of_one_frame(std::vector<weir_tensor_info> infos) {
  for (auto& info : infos) info.shape[0] = 1;
  return infos;
}

Status check_same_shapes(const std::vector<weir_tensor_info>& infos, uint32_t frame,
                         const std::vector<weir_tensor_info>& first) {
  for (size_t i = 0; i < first.size(); ++i)
    if (const auto difference = shape_difference(infos[i], first[i]); !difference.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the frames of a batch have different shapes",
                   .offered = "frame " + std::to_string(frame) + ": " + to_string(infos[i]),
                   .needed = "as frame 0: " + to_string(first[i]),
                   .difference = difference};
  return ok();
}

// Copies input i of each frame, one after the other, into tensor i of `out`.
void copy_frames(std::span<const weir_tensor> inputs, uint32_t frames,
                 std::span<const weir_tensor> out) {
  for (size_t i = 0; i < out.size(); ++i) {
    auto* to = static_cast<char*>(out[i].data);
    for (uint32_t frame = 0; frame < frames; ++frame) {
      const weir_tensor& from = inputs[frame * out.size() + i];
      if (from.bytes > 0) std::memcpy(to + frame * from.bytes, from.data, from.bytes);
    }
  }
}

// `inputs`: frame after frame. Each tensor has the shape of one frame, 1 in axis 0, or
// WEIR_RANK_UNKNOWN for the shape of `current` with 1 there. BATCH_UNSUPPORTED, and the errors of
// described_inputs.
Result<Batch> gather(std::span<const weir_tensor> inputs, uint32_t frames,
                     const weir_model_info& model, const std::vector<weir_tensor_info>& declared,
                     const std::vector<weir_tensor_info>& current) {
  if (model.flags & WEIR_MODEL_STATEFUL)
    return unsupported("the model keeps state between frames", std::to_string(frames) + " frames",
                       "one frame after the other");
  const uint64_t each = declared.size();
  if (frames == 0 || inputs.size() != each * frames)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the number of inputs is not a multiple of the model's inputs",
                 .offered = std::to_string(inputs.size()) + " tensors for " +
                            std::to_string(frames) + " frames",
                 .needed = std::to_string(each) + " for each of at least one frame",
                 .difference = "number of tensors"};
  for (size_t i = 0; i < each; ++i)
    if (auto status = check_axis(declared[i], frames, i); !status) return status.error();
  const auto one_declared = of_one_frame(declared), one_current = of_one_frame(current);
  const auto described = [&](uint64_t frame) {
    return described_inputs(inputs.subspan(frame * each, each), one_declared, one_current);
  };
  auto first = described(0);
  if (!first) return first.error();
  Batch out;
  out.infos = *first;
  for (auto& info : out.infos) info.shape[0] = frames;
  // Fails here for a number of frames that exceeds memory, before the other frames are read.
  out.memory = Results(out.infos);
  if (auto status = out.memory.allocate(1); !status) return status.error();
  for (uint32_t frame = 1; frame < frames; ++frame) {
    const auto infos = described(frame);
    if (!infos) return infos.error();
    if (auto status = check_same_shapes(*infos, frame, *first); !status) return status.error();
  }
  copy_frames(inputs, frames, out.memory.tensors());
  return out;
}

// Checks that the outputs of the batch contain its frames in axis 0.
Status check_batched(const std::vector<weir_tensor>& outputs, uint32_t frames) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    const weir_tensor_info& info = outputs[i].info;
    if (info.rank == 0 || info.rank > WEIR_RANK_LIMIT || info.shape[0] != frames)
      return unsupported(place_text("output", i, info) + " does not hold the frames of the batch",
                         to_string(info), std::to_string(frames) + " in axis 0");
  }
  return ok();
}

using Clock = std::chrono::steady_clock;
using Infos = std::vector<weir_tensor_info>;

Error timeout_error(std::string what, DirectModel::Limit limit) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(limit).count();
  return Error{
      .code = Code::WORKER_TIMEOUT,
      .what = std::move(what),
      .offered = "no result",
      .needed = "a result within " + std::to_string(ms) + " ms",
      .fix = "a longer time-out; the model accepts no other call until this one has ended"};
}

bool same_shapes(const Infos& a, const Infos& b) {
  const auto same = [](const weir_tensor_info& x, const weir_tensor_info& y) {
    return x.type == y.type && x.rank == y.rank && shape_difference(x, y).empty() &&
           shape_difference(y, x).empty();  // an open extent differs from a known one
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

}  // namespace

// An invoke with all that it uses, so that it can continue without its caller.
struct DirectModel::Job {
  Inputs inputs;
  Results results;
  bool ended = false, abandoned = false;  // guarded by the core's mutex
  Result<bool> result = false;            // once it has ended

  Result<bool> run(infer::Session& session) {
    weir_frame in{};
    in.struct_size = sizeof in;
    in.pts = in.duration = in.deadline = -1;
    weir_frame out = in;
    in.tensors = inputs.tensors().data();
    in.n_tensors = static_cast<uint32_t>(inputs.tensors().size());
    out.tensors = results.tensors().data();
    out.n_tensors = static_cast<uint32_t>(results.tensors().size());
    auto filled = session.invoke(in, out);
    if (filled && *filled)
      if (auto status = results.check(); !status) return status.error();
    return filled;
  }
};

struct DirectModel::Core {
  explicit Core(std::unique_ptr<infer::Session> s)
      : session(std::move(s)),
        inputs(session->model().inputs()),
        outputs(session->model().outputs()) {}

  const infer::Model& model() const noexcept { return session->model(); }
  // Computes the outputs for these inputs. Requires the turn.
  Result<Infos> resolve(const Infos& wanted);
  void give_back() {
    turn = Turns::Free;
    free.notify_one();
  }

  const std::unique_ptr<infer::Session> session;
  mutable std::mutex mutex;  // guards turn, limit, inputs, outputs; never held in the engine
  std::condition_variable free;
  enum class Turns { Free, Taken, Abandoned } turn = Turns::Free;
  Limit limit{0};
  Infos inputs, outputs;  // set by reshape(); written by the owner of the turn
  // For the owner of the turn:
  Infos resolved_inputs, resolved_outputs;  // the last ones passed to the engine
  bool resolved = false;
  std::optional<CallThread> thread;  // created on first use
};

Result<Infos> DirectModel::Core::resolve(const Infos& wanted) {
  if (resolved && same_shapes(wanted, resolved_inputs)) return resolved_outputs;
  resolved = false;
  auto out = session->resolve(wanted);
  if (!out) return out.error();
  for (size_t i = 0; i < out->size(); ++i) {
    auto& info = (*out)[i];
    info.name = i < model().outputs().size() ? model().outputs()[i].name : nullptr;
    if (info.rank > WEIR_RANK_LIMIT) info.rank = WEIR_RANK_UNKNOWN;
  }
  resolved_inputs = wanted;
  resolved_outputs = *out;
  resolved = true;
  return out;
}

// The right to call the engine, released at the end of the scope or by a job that timed out.
class DirectModel::Turn {
 public:
  explicit Turn(std::shared_ptr<Core> core) : core_(std::move(core)) {
    std::unique_lock lock(core_->mutex);
    limit_ = core_->limit;
    deadline_ = deadline_after(Clock::now(), limit_);
    const auto not_taken = [this] { return core_->turn != Core::Turns::Taken; };
    if (!limited()) {
      core_->free.wait(lock, not_taken);
    } else if (!core_->free.wait_until(lock, deadline_, not_taken)) {
      refusal_ = timeout_error("another call of the model did not return in time", limit_);
      return;
    }
    if (core_->turn == Core::Turns::Abandoned) {
      refusal_ = timeout_error("the model is still running an invoke that timed out", limit_);
      return;
    }
    core_->turn = Core::Turns::Taken;
    held_ = true;
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  ~Turn() {
    if (!held_) return;
    std::lock_guard lock(core_->mutex);
    core_->give_back();
  }
  const std::optional<Error>& refusal() const noexcept { return refusal_; }
  bool limited() const noexcept { return limit_.count() > 0; }

  Result<bool> run(const std::shared_ptr<Job>& job) {
    if (!limited()) return job->run(*core_->session);
    if (!core_->thread) core_->thread.emplace();
    const auto call = [core = core_, job] {
      Result<bool> result = false;
      try {
        result = job->run(*core->session);
      } catch (const std::exception& e) {
        result = Error{.code = Code::INTERNAL, .what = e.what()};
      }
      std::lock_guard lock(core->mutex);
      job->result = std::move(result);
      job->ended = true;
      if (job->abandoned) core->give_back();
    };
    core_->thread->run(call, deadline_ - Clock::now());
    std::lock_guard lock(core_->mutex);
    if (job->ended) return job->result;
    job->abandoned = true;
    core_->turn = Core::Turns::Abandoned;
    held_ = false;
    return timeout_error(kInvokeTimedOut, limit_);
  }

 private:
  std::shared_ptr<Core> core_;
  Limit limit_{0};
  Clock::time_point deadline_;
  std::optional<Error> refusal_;
  bool held_ = false;
};

Result<const weir_engine*> engine_for(const std::string& name, std::span<const std::string> paths) {
  auto& library = infer::ModuleLibrary::instance();
  if (name.empty() || equal_ignoring_case(name, "auto") || equal_ignoring_case(name, "any"))
    return library.engine_for_model(paths);
  return library.engine(name);
}

Result<std::unique_ptr<DirectModel>> DirectModel::open(const weir_engine& engine,
                                                       const infer::OpenOptions& options) {
  auto model = infer::Model::open(engine, options);
  if (!model) return model.error();
  auto session = infer::Session::create(*std::move(model));
  if (!session) return session.error();
  return std::unique_ptr<DirectModel>(new DirectModel(std::make_shared<Core>(*std::move(session))));
}

const infer::Model& DirectModel::model() const noexcept {
  return core_->model();
}

Infos DirectModel::inputs() const {
  std::lock_guard lock(core_->mutex);
  return core_->inputs;
}

Infos DirectModel::outputs() const {
  std::lock_guard lock(core_->mutex);
  return core_->outputs;
}

void DirectModel::set_limit(Limit limit) noexcept {
  std::lock_guard lock(core_->mutex);
  core_->limit = limit;
}

Status DirectModel::reshape(const Infos& wanted) {
  Turn turn(core_);
  if (turn.refusal()) return *turn.refusal();
  auto shapes = reshaped(declared(wanted.size()), wanted);
  if (!shapes) return shapes.error();
  auto outputs = core_->resolve(*shapes);
  if (!outputs) return outputs.error();
  std::lock_guard lock(core_->mutex);
  core_->inputs = *std::move(shapes);
  core_->outputs = *std::move(outputs);
  return ok();
}

Result<DirectModel::Outcome> DirectModel::invoke(std::span<const weir_tensor> inputs,
                                                 std::span<weir_tensor> into) {
  Turn turn(core_);
  if (turn.refusal()) return *turn.refusal();
  const auto model_inputs = declared(inputs.size());
  const auto infos = described_inputs(
      inputs, model_inputs, core_->inputs.size() == inputs.size() ? core_->inputs : model_inputs);
  if (!infos) return infos.error();
  const auto outputs = core_->resolve(*infos);
  if (!outputs) return outputs.error();
  if (auto status = check_outputs(into, *outputs); !status) return status.error();
  auto taken = Inputs::take(inputs, *infos, needs(), turn.limited());
  if (!taken) return taken.error();
  return run(turn, *std::move(taken), *outputs, into);
}

Result<DirectModel::Outcome> DirectModel::invoke_batch(std::span<const weir_tensor> inputs,
                                                       uint32_t frames) {
  Turn turn(core_);
  if (turn.refusal()) return *turn.refusal();
  auto batch = gather(inputs, frames, model().info(), model().inputs(), core_->inputs);
  if (!batch) return batch.error();
  const auto outputs = core_->resolve(batch->infos);
  if (!outputs) return outputs.error();
  auto taken = Inputs::take(batch->memory.tensors(), batch->infos, needs(), turn.limited());
  if (!taken) return taken.error();
  auto outcome = run(turn, *std::move(taken), *outputs, {});
  if (!outcome || outcome->dropped) return outcome;
  if (auto status = check_batched(outcome->results.tensors(), frames); !status)
    return status.error();
  outcome->results.set_frames(frames);
  return outcome;
}

Infos DirectModel::declared(size_t given) const {
  if (!model().inputs().empty()) return model().inputs();
  weir_tensor_info any{};
  any.type = WEIR_TYPE_END;
  any.rank = WEIR_RANK_UNKNOWN;
  any.batch_axis = WEIR_NO_BATCH_AXIS;
  return Infos(given, any);
}

MemoryNeeds DirectModel::needs() const noexcept {
  return {model().info().alignment, model().info().input_padding};
}

Result<DirectModel::Outcome> DirectModel::run(Turn& turn, Inputs inputs, const Infos& outputs,
                                              std::span<weir_tensor> into) {
  const auto job = std::make_shared<Job>();
  job->inputs = std::move(inputs);
  job->results = Results(outputs);
  // The caller's memory may be gone when a job that timed out ends.
  if (!turn.limited())
    for (size_t i = 0; i < into.size(); ++i)
      if (is_fixed(outputs[i])) job->results.lend(i, into[i].data, into[i].bytes);
  if (auto status = job->results.allocate(needs().alignment); !status) return status.error();
  const auto filled = turn.run(job);
  if (!filled) return filled.error();
  Outcome out{!*filled, std::move(job->results)};
  if (!out.dropped && !into.empty())
    if (auto status = out.results.copy_to(into); !status) return status.error();
  return out;
}

}  // namespace weir::direct
