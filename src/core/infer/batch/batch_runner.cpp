// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_runner.hpp"

#include <algorithm>
#include <cstdint>
#include <string>

#include "weir/abi.h"

namespace weir::infer {
namespace {

constexpr size_t kBlockAlignment = 64;  // of each output in a block
constexpr size_t kRetained = 4;         // unused batch blocks to keep

Error out_of_memory() {
  return Error{.code = Code::OUT_OF_MEMORY, .what = "no memory for a batch"};
}

std::vector<BatchLayout> layouts(const std::vector<weir_tensor_info>& infos,
                                 const std::vector<uint32_t>& axes) {
  std::vector<BatchLayout> out;
  for (size_t i = 0; i < infos.size(); ++i) out.push_back(BatchLayout::of(infos[i], axes[i]));
  return out;
}

// Offsets of the tensors of `slots` frames within one block; the last entry is its size.
std::vector<size_t> offsets(const std::vector<BatchLayout>& layouts, size_t slots) {
  std::vector<size_t> out{0};
  for (const auto& layout : layouts) {
    const size_t bytes = layout.frame_bytes() * slots;
    out.push_back((out.back() + bytes + kBlockAlignment - 1) / kBlockAlignment * kBlockAlignment);
  }
  return out;
}

// Names may be freed before the runner.
BatchShapes nameless(BatchShapes shapes) {
  for (auto* infos : {&shapes.inputs, &shapes.outputs})
    for (auto& info : *infos) info.name = nullptr;
  return shapes;
}

std::vector<weir_tensor> tensors(const std::vector<weir_tensor_info>& infos) {
  std::vector<weir_tensor> out(infos.size());
  for (size_t i = 0; i < infos.size(); ++i) {
    out[i].info = infos[i];
    out[i].memory_kind = WEIR_MEMORY_HOST;
    out[i].fence_fd = -1;
  }
  return out;
}

void set_memory(weir_tensor* tensor, void* data, uint64_t bytes, uint64_t capacity) {
  tensor->data = data;
  tensor->bytes = bytes;
  tensor->capacity = capacity;
}

bool suits(const weir_tensor& tensor, const InputMemory& memory) {
  return reinterpret_cast<uintptr_t>(tensor.data) % memory.alignment == 0 &&
         tensor.capacity >= tensor.bytes + memory.padding;
}

// When the results are useless for every frame; 0 = never.
int64_t last_expiry(const BatchJobs& jobs) {
  int64_t last = 0;
  for (const auto& job : jobs) {
    const int64_t expires = job->expires();
    if (expires == 0) return 0;
    last = std::max(last, expires);
  }
  return last;
}

}  // namespace

size_t frames_to_run(size_t there, const BatchShapes& shapes, std::chrono::nanoseconds reshape,
                     std::optional<std::chrono::nanoseconds> full_invoke) noexcept {
  if (shapes.axes.fixed || !full_invoke) return shapes.batch_size;
  const auto missing = static_cast<double>(shapes.batch_size - there);
  const double padding =
      static_cast<double>(full_invoke->count()) * missing / static_cast<double>(shapes.batch_size);
  return 2.0 * static_cast<double>(reshape.count()) < padding ? there : shapes.batch_size;
}

BatchRunner::BatchRunner(BatchShapes shapes, InputMemory memory, std::chrono::nanoseconds reshape,
                         Invoke invoke)
    : shapes_(nameless(std::move(shapes))),
      memory_(memory),
      reshape_(reshape),
      invoke_(std::move(invoke)),
      input_layouts_(layouts(shapes_.inputs, shapes_.axes.inputs)),
      output_layouts_(layouts(shapes_.outputs, shapes_.axes.outputs)),
      output_offsets_(offsets(output_layouts_, shapes_.batch_size)),
      piece_offsets_(offsets(output_layouts_, 1)),
      output_pool_(std::in_place, output_offsets_.back(), kBlockAlignment, kRetained),
      inputs_(tensors(shapes_.inputs)),
      outputs_(tensors(shapes_.outputs)),
      slices_(outputs_),
      input_blocks_(inputs_.size()) {
  for (const auto& layout : input_layouts_)
    input_pools_.emplace_back(layout.frame_bytes() * shapes_.batch_size + memory_.padding,
                              std::max(memory_.alignment, kBlockAlignment), 1);
  if (!std::all_of(output_layouts_.begin(), output_layouts_.end(),
                   [](const BatchLayout& layout) { return layout.in_one_piece(); }))
    piece_pool_.emplace(piece_offsets_.back(), kBlockAlignment, kRetained * shapes_.batch_size);
}

void BatchRunner::run(BatchJobs& jobs) {
  const auto fail_the_rest = [&jobs](const Error& error) {
    for (auto& job : jobs)
      if (job) job->failed(error);
  };
  try {
    run_checked(jobs);
  } catch (const std::bad_alloc&) {
    fail_the_rest(out_of_memory());
  } catch (const std::exception& thrown) {
    fail_the_rest(
        {.code = Code::INTERNAL, .what = "an exception ended a batch", .offered = thrown.what()});
  }
  output_block_.reset();
}

// Fails only the frames whose size is wrong.
void BatchRunner::refuse_wrong_sizes(BatchJobs& jobs) {
  for (auto& job : jobs) {
    const auto given = job->inputs();
    const bool right =
        given.size() == inputs_.size() &&
        std::equal(given.begin(), given.end(), input_layouts_.begin(),
                   [](const weir_tensor& tensor, const BatchLayout& layout) {
                     return tensor.bytes == layout.frame_bytes() && (tensor.data || !tensor.bytes);
                   });
    if (right) continue;
    job->failed({.code = Code::FRAME_SIZE,
                 .what = "a frame differs in size from the others of its batch",
                 .offered = std::to_string(given.size()) + " tensors, the first of " +
                            std::to_string(given.empty() ? 0 : given[0].bytes) + " bytes",
                 .needed = std::to_string(inputs_.size()) + " tensors, the first of " +
                           std::to_string(input_layouts_[0].frame_bytes()) + " bytes"});
    job.reset();
  }
  std::erase(jobs, nullptr);
}

void BatchRunner::run_checked(BatchJobs& jobs) {
  std::erase_if(jobs, [](const auto& job) { return job->end_if_useless(); });
  refuse_wrong_sizes(jobs);
  if (jobs.empty()) return;
  const size_t slots = frames_to_run(jobs.size(), shapes_, reshape_, full_invoke_);
  ++run_.number;
  run_.frames = jobs.size();
  auto kept = [&]() -> Result<bool> {
    if (auto status = describe_inputs(jobs, slots); !status) return status.error();
    if (auto status = describe_outputs(slots); !status) return status.error();
    return invoke(slots, last_expiry(jobs));
  }();
  Status status = kept ? ok() : Status(kept.error());
  if (status && *kept) status = hand_out(jobs, slots);
  for (auto& job : jobs)
    if (job) status ? job->dropped(run_) : job->failed(status.error());
}

Status BatchRunner::describe_inputs(const BatchJobs& jobs, size_t slots) {
  copied_ = 0;
  for (size_t i = 0; i < inputs_.size(); ++i) {
    inputs_[i].info.shape[shapes_.axes.inputs[i]] =
        shapes_.inputs[i].shape[shapes_.axes.inputs[i]] * static_cast<int64_t>(slots);
    inputs_[i].flags = WEIR_TENSOR_READONLY;
    if (auto status = describe_input(jobs, i, slots); !status) return status;
  }
  return ok();
}

Status BatchRunner::describe_input(const BatchJobs& jobs, size_t index, size_t slots) {
  const auto frame = [&](size_t slot) -> const weir_tensor& {
    return jobs[std::min(slot, jobs.size() - 1)]->inputs()[index];
  };
  if (slots == 1 && suits(frame(0), memory_)) {
    set_memory(&inputs_[index], frame(0).data, frame(0).bytes, frame(0).capacity);
    return ok();
  }
  auto& block = input_blocks_[index];
  if (!block) block = input_pools_[index].take();
  if (!block) return out_of_memory();
  const BatchLayout& layout = input_layouts_[index];
  for (size_t slot = 0; slot < slots; ++slot)
    layout.put({static_cast<const std::byte*>(frame(slot).data), layout.frame_bytes()}, slot, slots,
               block.get());
  copied_ += layout.frame_bytes();
  set_memory(&inputs_[index], block.get(), layout.frame_bytes() * slots,
             input_pools_[index].bytes());
  return ok();
}

Status BatchRunner::describe_outputs(size_t slots) {
  output_block_ = output_pool_->take();
  if (!output_block_) return out_of_memory();
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const size_t bytes = output_layouts_[i].frame_bytes() * slots;
    const uint32_t axis = shapes_.axes.outputs[i];
    outputs_[i].info = shapes_.outputs[i];
    outputs_[i].info.shape[axis] *= static_cast<int64_t>(slots);
    set_memory(&outputs_[i], output_block_.get() + output_offsets_[i], bytes, bytes);
  }
  return ok();
}

Result<bool> BatchRunner::invoke(size_t slots, int64_t expires) {
  weir_frame in{}, out{};
  in.struct_size = out.struct_size = sizeof in;
  in.pts = in.duration = in.deadline = out.pts = out.duration = out.deadline = -1;
  in.expires = expires;
  in.sequence = out.sequence = run_.number;
  in.n_tensors = static_cast<uint32_t>(inputs_.size());
  in.tensors = inputs_.data();
  out.n_tensors = static_cast<uint32_t>(outputs_.size());
  out.tensors = outputs_.data();
  const auto begin = std::chrono::steady_clock::now();
  auto kept = invoke_(in, out, &run_.end);
  run_.invoke = std::chrono::steady_clock::now() - begin;
  if (kept && slots == shapes_.batch_size) full_invoke_ = run_.invoke;
  return kept;
}

// The time of the batch, until which a server may answer, can be later than that of the frame.
bool BatchRunner::is_late(const BatchJob& job) const {
  if (run_.end.answered_by.empty()) return false;
  const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
  const int64_t expires = job.expires();
  return expires > 0 && now.count() > expires;
}

Status BatchRunner::hand_out(BatchJobs& jobs, size_t slots) {
  BatchRun late = run_;
  late.end.reason = WEIR_RESULT_LATE;
  for (size_t slot = 0; slot < jobs.size(); ++slot) {
    if (is_late(*jobs[slot])) {
      jobs[slot]->dropped(late);
      jobs[slot].reset();
      continue;
    }
    std::shared_ptr<void> owner;
    const auto cut = slice(slot, slots, &owner);
    if (!cut) return cut.error();
    jobs[slot]->done(run_, slices_, owner, copied_ + *cut);
    jobs[slot].reset();
  }
  return ok();
}

// Points slices_ to the outputs of one frame. Returns the number of bytes copied.
Result<uint64_t> BatchRunner::slice(size_t slot, size_t slots, std::shared_ptr<void>* owner) {
  *owner = output_block_;
  std::shared_ptr<std::byte> pieces;
  uint64_t cut = 0;
  for (size_t i = 0; i < slices_.size(); ++i) {
    const BatchLayout& layout = output_layouts_[i];
    const auto* batch = static_cast<const std::byte*>(outputs_[i].data);
    auto* at = static_cast<std::byte*>(outputs_[i].data) + slot * layout.frame_bytes();
    if (!layout.in_one_piece()) {
      if (!pieces) pieces = piece_pool_->take();
      if (!pieces) return out_of_memory();
      at = pieces.get() + piece_offsets_[i];
      layout.get(batch, slot, slots, {at, layout.frame_bytes()});
      cut += layout.frame_bytes();
    }
    set_memory(&slices_[i], at, layout.frame_bytes(), layout.frame_bytes());
  }
  if (pieces)
    *owner = std::make_shared<std::pair<std::shared_ptr<std::byte>, std::shared_ptr<std::byte>>>(
        output_block_, std::move(pieces));
  return cut;
}

}  // namespace weir::infer
