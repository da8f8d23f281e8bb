// Runs one frame in a worker: tensors in shared memory, everything else in messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>

#include "core/infer/module/host.hpp"
#include "core/isolate/worker.hpp"

namespace weir::isolate {
namespace {

constexpr uint64_t kMaxEngineBytes = uint64_t{1}
                                     << 30;  // limit for outputs that an engine allocates
constexpr size_t kBlocksBeforeSweep = 64;

Status allocate(uint64_t bytes, weir_tensor* tensor) {
  weir_tensor memory{};
  if (infer::host().allocate(nullptr, WEIR_MEMORY_HOST, bytes, 1, &memory) < 0)
    return Error{.code = Code::OUT_OF_MEMORY, .what = "no memory for an output"};
  tensor->data = memory.data;
  tensor->capacity = memory.capacity;
  tensor->owner = memory.owner;
  tensor->release = memory.release;
  return ok();
}

}  // namespace

void Worker::forget_blocks_that_are_gone() {
  size_t kept = 0;
  for (size_t i = 0; i < shared_.size(); ++i) {
    if (shared_[i].expired()) {
      writer_.begin(Kind::Forget);
      writer_.put(shared_ids_[i]);
      channel_.send(writer_.finish(), deadline(1));  // the end of a worker is detected later
      continue;
    }
    std::swap(shared_[kept], shared_[i]);
    shared_ids_[kept++] = shared_ids_[i];
  }
  shared_.resize(kept);
  shared_ids_.resize(kept);
}

// Call it before a message is begun, since it sends its own.
Status Worker::share(const std::shared_ptr<SharedBlock>& block) {
  if (std::find(shared_ids_.begin(), shared_ids_.end(), block->id()) != shared_ids_.end())
    return ok();
  if (shared_.size() >= kBlocksBeforeSweep) forget_blocks_that_are_gone();
  writer_.begin(Kind::Block);
  writer_.put(BlockCall{block->id(), block->bytes(), block->sharing() == Sharing::WrittenByWorker});
  const auto passage = channel_.send(writer_.finish(), deadline(1), block->descriptor());
  if (passage != Passage::Done) return lost(passage, on_frame());
  shared_.push_back(block);
  shared_ids_.push_back(block->id());
  return ok();
}

Result<InputCall> Worker::place_input(size_t index, const weir_tensor& tensor,
                                      const SharedArena& arena, uint64_t* copied) {
  if (tensor.memory_kind != WEIR_MEMORY_HOST)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "a worker process accepts host memory only",
                 .offered = "memory kind " + std::to_string(tensor.memory_kind),
                 .needed = "memory kind 0"};
  const uint64_t alignment = std::max<uint32_t>(facts_->info.alignment, 1);
  const uint64_t needed = tensor.bytes + facts_->info.input_padding;
  InputCall call{0, 0, without_pointers(tensor)};
  const auto place = arena.find(tensor.data, tensor.bytes);
  if (place && place->offset % alignment == 0 && place->capacity >= needed) {
    if (auto status = share(place->block); !status) return status.error();
    call.block = place->block->id();
    call.offset = place->offset;
    call.tensor.capacity = place->capacity;
    return call;
  }
  if (staging_.size() <= index) staging_.resize(index + 1);
  auto& block = staging_[index];
  if (!block || block->bytes() < needed) {
    auto made = SharedBlock::create(needed, Sharing::ReadByWorker);
    if (!made) return made.error();
    block = *std::move(made);
  }
  if (auto status = share(block); !status) return status.error();
  if (tensor.bytes > 0) std::memcpy(block->data(), tensor.data, tensor.bytes);
  *copied += tensor.bytes;
  call.block = block->id();
  call.tensor.capacity = block->bytes();
  return call;
}

Status Worker::reserve_output(uint64_t bytes) {
  if (!output_ || output_->bytes() < bytes) {
    auto made = SharedBlock::create(bytes, Sharing::WrittenByWorker);
    if (!made) return made.error();
    output_ = *std::move(made);
  }
  return share(output_);
}

Status Worker::place_outputs(const weir_frame& out, uint64_t* end) {
  places_.assign(out.n_tensors, 0);
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    if (!out.tensors[i].data) continue;
    const auto at = place(out.tensors[i].bytes, end);
    if (!at)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "an output is too large",
                   .needed = "at most 1 TiB"};
    places_[i] = *at;
  }
  return reserve_output(*end);
}

void Worker::write_frame(const weir_frame& in, const weir_frame& out,
                         const std::vector<InputCall>& inputs) {
  FrameCall frame{};
  frame.pts = in.pts;
  frame.duration = in.duration;
  frame.deadline = in.deadline;
  frame.stream_id = in.stream_id;
  frame.sequence = in.sequence;
  frame.flags = in.flags;
  frame.maps = in.maps ? std::min(in.n_maps, kMaxMaps) : 0;
  frame.maps_of = in.maps_of;
  frame.output_block = output_->id();
  frame.inputs = in.n_tensors;
  frame.outputs = out.n_tensors;
  writer_.begin(Kind::Invoke);
  writer_.put(frame);
  for (uint32_t i = 0; i < frame.maps; ++i) writer_.put(in.maps[i]);
  for (const auto& call : inputs) writer_.put(call);
  for (uint32_t i = 0; i < out.n_tensors; ++i)
    writer_.put(
        OutputCall{places_[i], out.tensors[i].data != nullptr, without_pointers(out.tensors[i])});
}

Result<int> Worker::invoke(const weir_frame& in, weir_frame& out, const SharedArena& arena,
                           uint64_t* copied) {
  if (in.n_tensors > WEIR_TENSOR_LIMIT || out.n_tensors > WEIR_TENSOR_LIMIT)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame has too many tensors",
                 .needed = "at most 256"};
  const io::Deadline until = deadline(invokes_ == 0 ? 10 : 1);
  ++invokes_;
  std::vector<InputCall> inputs;
  for (uint32_t i = 0; i < in.n_tensors; ++i) {
    auto call = place_input(i, in.tensors[i], arena, copied);
    if (!call) return call.error();
    inputs.push_back(*call);
  }
  uint64_t end = 0;
  if (auto status = place_outputs(out, &end); !status) return status.error();
  write_frame(in, out, inputs);
  if (auto status = ask(Kind::Invoked, until, on_frame()); !status) return status.error();
  const Message response = std::move(response_);  // fetching outputs overwrites response_
  MessageReader invoked(response.body);
  const auto head = invoked.take<InvokeResponse>();
  if (head.result > 0) return head.result;
  if (head.result < 0 || head.outputs != out.n_tensors)
    return invalid_message(on_frame(), "a different number of outputs than the frame has");
  if (auto status = take_outputs(out, end, copied, &invoked, head.in_block != 0); !status)
    return status.error();
  return 0;
}

// The sizes come from the worker: each is checked against the given memory before use. Moves `end`
// beyond the outputs without memory.
Result<std::vector<OutputResponse>> Worker::read_outputs(const weir_frame& out,
                                                         MessageReader* response, uint64_t* end) {
  std::vector<OutputResponse> responses;
  const uint64_t max = *end + kMaxEngineBytes;
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    responses.push_back(response->take<OutputResponse>());
    const auto& [bytes, info] = responses.back();
    const bool given = out.tensors[i].data != nullptr;
    if (bytes > (given ? out.tensors[i].bytes : kMaxEngineBytes))
      return invalid_message(on_frame(), "an output of " + std::to_string(bytes) + " bytes");
    if (info.rank > WEIR_RANK_LIMIT && info.rank != WEIR_RANK_UNKNOWN)
      return invalid_message(on_frame(), "an output of rank " + std::to_string(info.rank));
    if (!given) places_[i] = *place(bytes, end);
    if (*end > max)
      return invalid_message(on_frame(), "outputs of " + std::to_string(*end) + " bytes");
  }
  if (!response->complete())
    return invalid_message(on_frame(), "a reply that is too short or too long");
  return responses;
}

// Has the worker write its outputs to places_ in memory of `end` bytes.
Status Worker::fetch_outputs(uint64_t end) {
  const auto from = output_;  // the worker reads it during Fetch
  if (auto status = reserve_output(end); !status) return status;
  writer_.begin(Kind::Fetch);
  writer_.put(output_->id());
  for (const uint64_t place : places_) writer_.put(place);
  return ask(Kind::Done, deadline(1), on_frame());
}

Status Worker::take_outputs(weir_frame& out, uint64_t end, uint64_t* copied,
                            MessageReader* response, bool in_block) {
  const auto responses = read_outputs(out, response, &end);
  if (!responses) return responses.error();
  if (in_block && end > output_->bytes())
    return invalid_message(on_frame(), "outputs beyond the end of their memory");
  if (!in_block)
    if (auto status = fetch_outputs(end); !status) return status;
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    auto& tensor = out.tensors[i];
    const auto& [bytes, info] = (*responses)[i];
    if (!tensor.data)
      if (auto status = allocate(bytes, &tensor); !status) return status;
    if (bytes > 0) std::memcpy(tensor.data, output_->data() + places_[i], bytes);
    *copied += bytes;
    tensor.bytes = bytes;
    const char* name = tensor.info.name;
    tensor.info = info;
    tensor.info.name = name;
  }
  return ok();
}

}  // namespace weir::isolate
