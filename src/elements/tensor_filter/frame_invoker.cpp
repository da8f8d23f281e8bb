// From buffer to buffer through a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/frame_invoker.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>

#include "elements/tensor_filter/buffer_owner.hpp"
#include "elements/tensor_filter/model_info.hpp"
#include "elements/tensor_filter/output_size.hpp"
#include "gstcpp/frame_errors.hpp"

namespace weir {
namespace {

// Memory that an engine allocated, kept until the GstMemory goes.
struct EngineMemory {
  void (*release)(void*);
  void* owner;
};
void free_engine_memory(gpointer data) {
  const std::unique_ptr<EngineMemory> memory(static_cast<EngineMemory*>(data));
  if (memory->release) memory->release(memory->owner);
}
GstMemory* adopt(weir_tensor* tensor) {
  auto* keep = new EngineMemory{tensor->release, tensor->owner};
  tensor->release = nullptr;
  return gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, tensor->data, tensor->bytes, 0,
                                tensor->bytes, keep, free_engine_memory);
}

void write_header(const TensorSpec& spec, Format format, std::span<std::byte> at) {
  TensorHeader header;
  header.format = format;
  header.spec = spec;
  write_tensor_header(header, at.first<kTensorHeaderBytes>());
}

Result<gst::TensorPiece> copy_of(const TensorSpec& spec, std::span<const std::byte> bytes,
                                 std::optional<Format> header) {
  const size_t head = header ? kTensorHeaderBytes : 0;
  auto memory = gst::allocate_memory(head + bytes.size());
  if (!memory) return memory.error();
  {
    const gst::MappedMemory map(memory->get(), GST_MAP_WRITE);
    if (!map) return gst::memory_ran_out(head + bytes.size());
    if (header) write_header(spec, *header, map.bytes());
    if (!bytes.empty()) std::memcpy(map.bytes().data() + head, bytes.data(), bytes.size());
  }
  return gst::TensorPiece{*std::move(memory), spec};
}

// An engine that decides sizes with each frame may leave out the last ones: no bytes, no rank.
size_t count_given(std::span<const weir_tensor> outputs) {
  size_t count = outputs.size();
  while (count > 1 && outputs[count - 1].bytes == 0 &&
         outputs[count - 1].info.rank == WEIR_RANK_UNKNOWN)
    --count;
  return count;
}

}  // namespace

struct FrameInvoker::Cleared {
  FrameInvoker* self;
  ~Cleared() { self->clear(); }
};

void FrameInvoker::describe() {
  describe_tensors(plan_.model_inputs, &inputs_);
  describe_tensors(plan_.model_outputs, &outputs_);
  described_ = outputs_;
  in_frame_ = {};
  in_frame_.struct_size = sizeof in_frame_;
  in_frame_.pts = in_frame_.duration = in_frame_.deadline = -1;
  out_frame_ = in_frame_;
  in_frame_.n_tensors = static_cast<uint32_t>(inputs_.size());
  in_frame_.tensors = inputs_.data();
  out_frame_.n_tensors = static_cast<uint32_t>(outputs_.size());
  out_frame_.tensors = outputs_.data();
}

Status FrameInvoker::prepare() {
  describe();
  pool_ = {};
  if (!plan_.has_memory() || (plan_.batch && outputs_.size() <= kMemoryLimit)) return ok();
  std::vector<TensorSpec> specs;
  for (const auto& shape : plan_.model_outputs) specs.push_back(to_spec(shape));
  auto pool =
      gst::FramePool::make(std::move(specs), flexible() ? Format::Flexible : Format::Static);
  if (!pool) return pool.error();
  pool_ = *std::move(pool);
  return ok();
}

void FrameInvoker::prepare_beside(const FrameInvoker& other) {
  describe();
  pool_ = other.pool_;
}

Status FrameInvoker::adapt_to(const std::vector<ModelShape>& inputs) {
  auto outputs = model_->resolve(*frame_, session_, inputs);
  if (!outputs) return outputs.error();
  session_rows_.clear();
  plan_.model_inputs = inputs;
  plan_.model_outputs = *std::move(outputs);
  plan_.outputs_fixed = std::all_of(plan_.model_outputs.begin(), plan_.model_outputs.end(),
                                    [](const auto& shape) { return shape.fixed(); });
  return prepare();
}

// Flexible streams: each frame says its own shapes.
Status FrameInvoker::follow_headers() {
  std::vector<TensorSpec> specs;
  for (const auto& view : reader_.tensors()) specs.push_back(view.spec);
  auto chosen = choose_tensors(specs, plan_.input_choice, "input-combination");
  if (!chosen) return chosen.error();
  auto shapes = fit(plan_.declared_inputs, *chosen);
  if (!shapes) return shapes.error();
  if (plan_.batch) return ok();  // the model has one shape, and the frame has it too
  const bool same = std::equal(
      shapes->begin(), shapes->end(), plan_.model_inputs.begin(), plan_.model_inputs.end(),
      [](const auto& a, const auto& b) { return a.type == b.type && a.shape == b.shape; });
  if (same && resolved_on_ == frame_->sessions_number()) return ok();
  if (auto status = adapt_to(*shapes); !status) return status;
  resolved_on_ = frame_->sessions_number();
  return ok();
}

// The payload, or a copy where its address or what is readable behind it does not suit the model.
std::span<std::byte> FrameInvoker::suitable(size_t index, const gst::TensorView& view,
                                            size_t* capacity) {
  const size_t size = view.payload.size(), needed = size + plan_.padding;
  if (reinterpret_cast<uintptr_t>(view.payload.data()) % plan_.alignment == 0 &&
      view.capacity >= needed)
    return view.payload;
  if (copies_.size() <= index) copies_.resize(index + 1);
  auto& copy = copies_[index];
  copy.resize(needed + plan_.alignment - 1);
  void* at = copy.data();
  size_t room = copy.size();
  std::align(plan_.alignment, needed, at, room);
  if (size > 0) std::memcpy(at, view.payload.data(), size);
  ledger_->copied(size);
  *capacity = needed;
  return {static_cast<std::byte*>(at), size};
}

Status FrameInvoker::describe_inputs() {
  const auto& views = reader_.tensors();
  const auto& choice = plan_.input_choice;
  const size_t count = choice.empty() ? views.size() : choice.size();
  if (plan_.input.format != Format::Static)
    if (auto status = follow_headers(); !status) return status;
  if (count != inputs_.size())
    return Error{Code::SPEC_MISMATCH,   "the frame has another number of tensors than the model",
                 std::to_string(count), std::to_string(inputs_.size()),
                 "number of tensors",   ""};
  for (size_t i = 0; i < count; ++i) {
    const auto& view = views[choice.empty() ? i : choice[i]];
    size_t capacity = view.capacity;
    const auto bytes = suitable(i, view, &capacity);
    inputs_[i].data = bytes.data();
    inputs_[i].bytes = bytes.size();
    inputs_[i].capacity = capacity;
    inputs_[i].flags = WEIR_TENSOR_READONLY;
  }
  return ok();
}

void FrameInvoker::describe_frame(GstBuffer* in, GstClockTime deadline) {
  const auto time = [](GstClockTime t) {
    return GST_CLOCK_TIME_IS_VALID(t) ? static_cast<int64_t>(t) : -1;
  };
  in_frame_.pts = out_frame_.pts = time(GST_BUFFER_PTS(in));
  in_frame_.duration = out_frame_.duration = time(GST_BUFFER_DURATION(in));
  maps_.fill(in, plan_.input_choice, &in_frame_);
  in_frame_.deadline = out_frame_.deadline = time(deadline);
}

void FrameInvoker::copy_maps(GstBuffer* in, GstBuffer* out) const {
  const auto of = gst::maps_of(in);
  const auto maps = gst::picture_maps(in);
  std::vector<PictureMap> copies(maps.begin(), maps.end());
  if (of == gst::MapsOf::Tensors && copies.size() > 1) {
    const auto& choice = plan_.output_choice;
    const size_t results = choice.empty() ? outputs_.size() : choice.outputs.size();
    const PictureMap of_input = copies[std::min(first_input(), copies.size() - 1)];
    copies.assign(results, of_input);
    for (size_t i = 0; i < choice.inputs.size(); ++i)
      copies.insert(copies.begin() + static_cast<std::ptrdiff_t>(i),
                    maps[std::min(choice.inputs[i], maps.size() - 1)]);
  }
  gst::set_picture_maps(out, std::move(copies), of);
}

Result<bool> FrameInvoker::invoke(GstBuffer* in) {
  BufferOwner owner(in, inputs_);
  const infer::FrameOwnerScope scope(in_frame_, &owner);
  const auto begin = std::chrono::steady_clock::now();
  auto kept = run_session();
  statistics_->record(std::chrono::steady_clock::now() - begin);
  return kept;
}

void FrameInvoker::release_engine_memory() noexcept {
  for (auto& tensor : outputs_) {
    if (tensor.release) tensor.release(tensor.owner);
    tensor.release = nullptr;
    tensor.data = nullptr;
    tensor.owner = nullptr;
  }
}

Result<gst::Ref<GstBuffer>> FrameInvoker::run(const infer::ModelUse::Frame& frame, GstBuffer* in,
                                              GstClockTime deadline) {
  use(frame);
  auto made = make(in, deadline);
  frame_ = nullptr;
  if (made && *made) copy_metas(in, made->get());
  return made;
}

// Time-stamps, metas, ways back.
void FrameInvoker::copy_metas(GstBuffer* in, GstBuffer* out) const {
  gst_buffer_copy_into(out, in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  copy_maps(in, out);
}

void FrameInvoker::clear() noexcept {
  pieces_.clear();
  writer_.unmap();
  reader_.clear();
  release_engine_memory();
}

Status FrameInvoker::begin(GstBuffer* in) {
  if (auto status = reader_.read(in, plan_.input); !status) return status.error();
  ledger_->copied(reader_.bytes_copied());
  return describe_inputs();
}

// A buffer of the pool, mapped for writing.
Result<gst::Ref<GstBuffer>> FrameInvoker::acquire() {
  auto pooled = plan_.limit ? pool_.acquire(*plan_.limit) : pool_.acquire();
  if (!pooled) return pooled;
  *pool_allocated_ = pool_.stats().allocated;
  if (auto status = writer_.map(pool_, pooled->get(), plan_.header_format()); !status) {
    writer_.unmap();  // before the buffer goes
    return status.error();
  }
  return pooled;
}

Result<gst::Ref<GstBuffer>> FrameInvoker::make(GstBuffer* in, GstClockTime deadline) {
  gst::Ref<GstBuffer> pooled;  // outlives its mapping
  const Cleared cleared{this};
  if (auto status = read(in, deadline); !status) return status.error();
  if (plan_.has_memory()) {
    auto acquired = acquire();
    if (!acquired) return acquired.error();
    pooled = *std::move(acquired);
    for (size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i].data = writer_.payloads()[i].data();
      outputs_[i].bytes = outputs_[i].capacity = writer_.payloads()[i].size();
    }
  }
  auto kept = invoke(in);
  if (!kept) return kept.error();
  if (!*kept) return gst::Ref<GstBuffer>{};
  if (plan_.has_memory())
    if (auto status = check_given_memory(); !status) return status.error();
  if (plain()) return pooled;
  return assemble(in, pooled, outputs_);
}

Result<gst::Ref<GstBuffer>> FrameInvoker::end(GstBuffer* in, std::span<const weir_tensor> outputs,
                                              const std::shared_ptr<void>& owner) {
  const Cleared cleared{this};
  if (plain() && outputs.size() > kMemoryLimit) {
    auto packed = pack(outputs);
    if (packed) copy_metas(in, packed->get());
    return packed;
  }
  for (size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].data = outputs[i].data;
    outputs_[i].bytes = outputs_[i].capacity = outputs[i].bytes;
    outputs_[i].owner = new std::shared_ptr<void>(owner);
    outputs_[i].release = [](void* kept) { delete static_cast<std::shared_ptr<void>*>(kept); };
  }
  auto made = assemble(in, {}, outputs_);
  if (made) copy_metas(in, made->get());
  return made;
}

// More tensors than a buffer has memories: the last memory holds several, as the pool writes it.
Result<gst::Ref<GstBuffer>> FrameInvoker::pack(std::span<const weir_tensor> outputs) {
  auto pooled = acquire();
  if (!pooled) return pooled;
  for (size_t i = 0; i < outputs.size(); ++i) {
    std::memcpy(writer_.payloads()[i].data(), outputs[i].data, outputs[i].bytes);
    ledger_->copied(outputs[i].bytes);
  }
  writer_.unmap();
  return pooled;
}

Result<gst::Ref<GstBuffer>> FrameInvoker::assemble(GstBuffer* in, gst::Ref<GstBuffer> pooled,
                                                   std::span<weir_tensor> outputs) {
  const auto& choice = plan_.output_choice;
  pieces_.clear();
  const auto take = [this](Result<gst::TensorPiece> piece) -> Status {
    if (!piece) return piece.error();
    pieces_.push_back(*std::move(piece));
    return ok();
  };
  for (const size_t index : choice.inputs)
    if (auto status = take(input_piece(in, index)); !status) return status.error();
  writer_.unmap();
  const size_t given = plan_.dynamic ? count_given(outputs) : outputs.size();
  const size_t count = choice.empty() ? given : choice.outputs.size();
  for (size_t i = 0; i < count; ++i) {
    const size_t index = choice.empty() ? i : choice.outputs[i];
    if (pooled && outputs.size() <= kMemoryLimit) {
      auto* memory = gst_buffer_peek_memory(pooled.get(), static_cast<guint>(index));
      pieces_.push_back({gst::Ref<GstMemory>::share(memory), pool_.tensors()[index]});
    } else if (auto status = take(output_piece(index, outputs[index])); !status) {
      return status.error();
    }
  }
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  if (auto status = gst::append_tensors(pieces_, out.get(), ledger_); !status)
    return status.error();
  return out;
}

Result<gst::TensorPiece> FrameInvoker::input_piece(GstBuffer* in, size_t index) {
  if (index >= reader_.tensors().size())
    return Error{Code::OPTION_VALUE,
                 "output-combination names an input that is not there",
                 "i" + std::to_string(index),
                 "",
                 "",
                 ""};
  const auto& view = reader_.tensors()[index];
  if (view.memory >= 0 && (view.header_bytes > 0) == flexible()) {
    auto* memory = gst_buffer_peek_memory(in, static_cast<guint>(view.memory));
    return gst::TensorPiece{gst::Ref<GstMemory>::share(memory), view.spec};
  }
  ledger_->copied(view.payload.size());
  return copy_of(view.spec, view.payload, header());
}

Result<gst::TensorPiece> FrameInvoker::output_piece(size_t index, weir_tensor& tensor) {
  if (tensor.bytes == 0)
    return Error{Code::INVOKE_FAILED,
                 "the engine made an output without elements",
                 "tensor " + std::to_string(index) + ": 0 bytes",
                 "at least one element: streams know no empty tensor",
                 "",
                 "let the engine drop such a frame (a result above 0), or write one element"};
  if (!tensor.data)
    return Error{Code::INVOKE_FAILED,
                 "the engine gave no memory for an output",
                 "tensor " + std::to_string(index),
                 "data and a release function",
                 "",
                 ""};
  const auto spec = to_spec(model_shape(tensor.info));
  if (!spec.valid() || spec.bytes() != tensor.bytes)
    return Error{Code::INVOKE_FAILED,
                 "the engine's output has another size than its shape says",
                 std::to_string(tensor.bytes) + " bytes",
                 spec.to_string(),
                 "tensor " + std::to_string(index),
                 ""};
  if (!flexible() && !same_shape(tensor.info, described_[index].info))
    return changed_size(index, tensor.info, plan_.model_outputs[index]);
  if (!flexible() && tensor.release)
    return gst::TensorPiece{gst::Ref<GstMemory>::adopt(adopt(&tensor)), spec};
  ledger_->copied(tensor.bytes);
  const std::span bytes(static_cast<const std::byte*>(tensor.data), tensor.bytes);
  return copy_of(spec, bytes, header());
}

}  // namespace weir
