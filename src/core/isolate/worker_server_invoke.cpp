// Runs a frame from shared memory through the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/infer/module/host.hpp"
#include "core/isolate/worker_server.hpp"

namespace weir::isolate {
namespace {

Error memory_is_missing() {
  return Error{.code = Code::OUT_OF_MEMORY,
               .what = "a worker process cannot access the memory of a frame",
               .needed = "room for the shared memory"};
}

Error unreadable_frame(const char* difference) {
  return Error{.code = Code::INTERNAL,
               .what = "a worker process cannot read a frame",
               .difference = difference};
}

}  // namespace

// The pipeline is not trusted either: tensors only get addresses computed in this process, and no
// size beyond their memory.
Status WorkerServer::read_frame(MessageReader* call) {
  const auto frame = call->take<FrameCall>();
  // A model that does not declare its tensors before the first frame takes any number of them.
  const auto fits = [](uint32_t count, const auto& model) {
    return model.empty() ? count <= WEIR_TENSOR_LIMIT : count == model.size();
  };
  if (!fits(frame.inputs, model_->inputs()) || !fits(frame.outputs, model_->outputs()))
    return unreadable_frame("a different number of tensors than the model has");
  inputs_.assign(frame.inputs, {});
  outputs_.assign(frame.outputs, {});
  places_.assign(outputs_.size(), 0);
  given_.assign(outputs_.size(), false);
  output_block_ = frame.output_block;
  maps_.resize(std::min(frame.maps, kMaxMaps));
  for (auto& map : maps_) map = call->take<weir_source_map>();
  set_frames(frame);
  if (auto status = read_inputs(call); !status) return status;
  if (auto status = read_outputs(call); !status) return status;
  return call->complete() ? ok() : Status(memory_is_missing());
}

void WorkerServer::set_frames(const FrameCall& frame) {
  in_ = {};
  in_.struct_size = sizeof in_;
  in_.n_tensors = static_cast<uint32_t>(inputs_.size());
  in_.tensors = inputs_.data();
  in_.pts = frame.pts;
  in_.duration = frame.duration;
  in_.deadline = frame.deadline;
  in_.stream_id = frame.stream_id;
  in_.sequence = frame.sequence;
  in_.flags = frame.flags;
  in_.n_maps = static_cast<uint32_t>(maps_.size());
  in_.maps_of = frame.maps_of;
  in_.maps = maps_.empty() ? nullptr : maps_.data();
  out_ = in_;
  out_.n_tensors = static_cast<uint32_t>(outputs_.size());
  out_.tensors = outputs_.data();
}

Status WorkerServer::read_inputs(MessageReader* call) {
  for (size_t i = 0; i < inputs_.size(); ++i) {
    const auto input = call->take<InputCall>();
    inputs_[i] = without_pointers(input.tensor);
    if (i < model_->inputs().size()) inputs_[i].info.name = model_->inputs()[i].name;
    inputs_[i].data = at(input.block, input.offset, input.tensor.capacity);
    if (!inputs_[i].data || input.tensor.bytes > input.tensor.capacity) return memory_is_missing();
    if (!has_legal_rank(inputs_[i].info))
      return unreadable_frame("a tensor with more than 16 dimensions");
  }
  return ok();
}

Status WorkerServer::read_outputs(MessageReader* call) {
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const auto output = call->take<OutputCall>();
    outputs_[i] = without_pointers(output.tensor);
    if (i < model_->outputs().size()) outputs_[i].info.name = model_->outputs()[i].name;
    places_[i] = output.offset;
    given_[i] = output.given != 0;
    if (!has_legal_rank(outputs_[i].info))
      return unreadable_frame("a tensor with more than 16 dimensions");
    if (!given_[i]) continue;
    outputs_[i].capacity = output.tensor.bytes;
    outputs_[i].data = at(output_block_, output.offset, output.tensor.bytes);
    if (!outputs_[i].data) return memory_is_missing();
  }
  return ok();
}

Status WorkerServer::invoke(MessageReader* call) {
  release_outputs();  // of a frame that was not fetched
  if (auto status = read_frame(call); !status) return status;
  weir_error error;
  const int result = model_->engine().invoke(session_, &in_, &out_, &error);
  if (result < 0) {
    release_outputs();
    return infer::take_error(&error, result, "the engine failed on a frame");
  }
  respond_to_invoke(result);
  return ok();
}

void WorkerServer::respond_to_invoke(int result) {
  writer_.begin(Kind::Invoked);
  if (result > 0) {
    release_outputs();
    writer_.put(InvokeResponse{result, 1, 0});
    return;
  }
  uint64_t end = 0;
  for (size_t i = 0; i < outputs_.size(); ++i)
    if (given_[i]) end = std::max(end, places_[i] + outputs_[i].bytes);
  bool placed = true;
  for (size_t i = 0; i < outputs_.size(); ++i) {
    if (given_[i]) continue;
    if (!outputs_[i].data) outputs_[i].bytes = 0;
    const auto at = place(outputs_[i].bytes, &end);
    placed = placed && at;
    if (at) places_[i] = *at;
  }
  const auto block = blocks_.find(output_block_);
  const bool fits = placed && block != blocks_.end() && end <= block->second.bytes();
  writer_.put(InvokeResponse{0, fits, static_cast<uint32_t>(outputs_.size())});
  for (const auto& tensor : outputs_) {
    OutputResponse response{tensor.bytes, tensor.info};
    response.info.name = nullptr;
    writer_.put(response);
  }
  if (fits) write_outputs(block->second);
}

// Copies outputs that the engine allocated, or did not write to their place.
void WorkerServer::write_outputs(Mapping& block) {
  for (size_t i = 0; i < outputs_.size(); ++i) {
    std::byte* const to = block.data() + places_[i];
    if (outputs_[i].data != to && outputs_[i].data && outputs_[i].bytes > 0)
      std::memcpy(to, outputs_[i].data, outputs_[i].bytes);
  }
  release_outputs();
}

void WorkerServer::release_outputs() {
  for (auto& tensor : outputs_)
    if (tensor.release) tensor.release(tensor.owner);
  outputs_.clear();
}

Status WorkerServer::fetch(MessageReader* call) {
  const auto id = call->take<uint64_t>();
  const auto block = blocks_.find(id);
  if (block == blocks_.end()) return memory_is_missing();
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const auto to = call->take<uint64_t>();
    // Outputs that the engine wrote into the previous block move as well.
    if (!at(id, to, outputs_[i].bytes)) return memory_is_missing();
    places_[i] = to;
  }
  if (!call->complete()) return memory_is_missing();
  write_outputs(block->second);
  writer_.begin(Kind::Done);
  return ok();
}

}  // namespace weir::isolate
