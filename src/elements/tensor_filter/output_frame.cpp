// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/output_frame.hpp"

#include <algorithm>
#include <cstring>

#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {
namespace {

// Memory that an engine allocated, released with the GstMemory.
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

Result<gst::TensorPiece> make_copy(const TensorSpec& spec, std::span<const std::byte> bytes,
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

// An engine that decides sizes with each frame may omit the last outputs: no bytes, no rank.
size_t count_given(std::span<const weir_tensor> outputs) {
  size_t count = outputs.size();
  while (count > 1 && outputs[count - 1].bytes == 0 &&
         outputs[count - 1].info.rank == WEIR_RANK_UNKNOWN)
    --count;
  return count;
}

Error changed_size(size_t index, const weir_tensor_info& given, const ModelTensor& expected) {
  return Error{.code = Code::INVOKE_FAILED,
               .what = "the model changed the size of an output",
               .offered = model_tensor(given).to_string(),
               .needed = expected.to_string(),
               .difference = "tensor " + std::to_string(index),
               .fix = "tensor_filter invoke-dynamic=true"};
}

}  // namespace

bool same_shape(const weir_tensor_info& a, const weir_tensor_info& b) noexcept {
  return a.type == b.type && a.rank == b.rank &&
         std::equal(a.shape, a.shape + std::min<uint32_t>(a.rank, WEIR_RANK_LIMIT), b.shape);
}

void OutputFrame::describe(SharedFilterPlan plan) {
  plan_ = std::move(plan);
  tensors_ = frame_tensors(plan_->model_outputs);
  described_ = tensors_;
  frame_ = {};
  frame_.struct_size = sizeof frame_;
  frame_.n_tensors = static_cast<uint32_t>(tensors_.size());
  frame_.tensors = tensors_.data();
}

Status OutputFrame::prepare(SharedFilterPlan plan) {
  describe(std::move(plan));
  pool_ = {};
  // Batches have their own memory; the pool is needed only for packed tensors.
  if (!plan_->has_memory() || (plan_->batch && tensors_.size() <= kMemoryLimit)) return ok();
  std::vector<TensorSpec> specs;
  for (const auto& shape : plan_->model_outputs) specs.push_back(to_spec(shape));
  auto pool =
      gst::FramePool::make(std::move(specs), flexible() ? Format::Flexible : Format::Static);
  if (!pool) {
    plan_.reset();  // the next frame prepares again
    return pool.error();
  }
  pool_ = *std::move(pool);
  return ok();
}

void OutputFrame::prepare_beside(const OutputFrame& other) {
  describe(other.plan_);
  pool_ = other.pool_;
}

// Takes a buffer from the pool and maps it for writing.
Status OutputFrame::acquire_memory() {
  auto pooled = plan_->limit ? pool_.acquire(*plan_->limit) : pool_.acquire();
  if (!pooled) return pooled.error();
  pooled_ = *std::move(pooled);
  *pool_allocated_ = pool_.stats().allocated;
  return writer_.map(pool_, pooled_.get(), plan_->header_format());
}

Status OutputFrame::acquire(const InputFrame& in) {
  frame_.pts = in.frame().pts;
  frame_.duration = in.frame().duration;
  frame_.deadline = in.frame().deadline;
  if (!plan_->has_memory()) {
    tensors_ = described_;  // the engine changed them for the previous frame
    return ok();
  }
  if (auto status = acquire_memory(); !status) return status;
  for (size_t i = 0; i < tensors_.size(); ++i) {
    tensors_[i].data = writer_.payloads()[i].data();
    tensors_[i].bytes = tensors_[i].capacity = writer_.payloads()[i].size();
  }
  return ok();
}

void OutputFrame::clear() noexcept {
  pieces_.clear();
  writer_.unmap();
  pooled_ = {};
  for (auto& tensor : tensors_) {
    if (tensor.release) tensor.release(tensor.owner);
    tensor.release = nullptr;
    tensor.data = nullptr;
    tensor.owner = nullptr;
  }
}

OutputFrame::Made OutputFrame::finish(const InputFrame& in) {
  if (plan_->has_memory())
    if (auto status = check_given_memory(); !status) return status.error();
  if (!plain()) return with_metas(in, assemble(in, tensors_));
  writer_.unmap();
  return with_metas(in, std::move(pooled_));
}

OutputFrame::Made OutputFrame::collect(const InputFrame& in, const weir_frame& given) {
  if (given.n_tensors != tensors_.size() || (given.n_tensors > 0 && !given.tensors))
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "the engine returned a different number of outputs than the model has",
                 .offered = std::to_string(given.tensors ? given.n_tensors : 0),
                 .needed = std::to_string(tensors_.size()),
                 .difference = "number of tensors"};
  return with_metas(in, assemble(in, {given.tensors, given.n_tensors}));
}

OutputFrame::Made OutputFrame::collect(const InputFrame& in, std::span<const weir_tensor> outputs,
                                       const std::shared_ptr<void>& owner) {
  if (plain() && outputs.size() > kMemoryLimit) return with_metas(in, pack(outputs));
  for (size_t i = 0; i < tensors_.size(); ++i) {
    tensors_[i].data = outputs[i].data;
    tensors_[i].bytes = tensors_[i].capacity = outputs[i].bytes;
    tensors_[i].owner = new std::shared_ptr<void>(owner);
    tensors_[i].release = [](void* kept) { delete static_cast<std::shared_ptr<void>*>(kept); };
  }
  return with_metas(in, assemble(in, tensors_));
}

Status OutputFrame::check_given_memory() const {
  for (size_t i = 0; i < tensors_.size(); ++i) {
    const weir_tensor& tensor = tensors_[i];
    const bool same = tensor.data == writer_.payloads()[i].data() &&
                      tensor.bytes == writer_.payloads()[i].size() &&
                      same_shape(tensor.info, described_[i].info);
    if (!same) return changed_size(i, tensor.info, plan_->model_outputs[i]);
  }
  return ok();
}

// For more tensors than a buffer has memories: the last memory holds several, as in pooled buffers.
OutputFrame::Made OutputFrame::pack(std::span<const weir_tensor> outputs) {
  if (auto status = acquire_memory(); !status) return status.error();
  for (size_t i = 0; i < outputs.size(); ++i) {
    std::memcpy(writer_.payloads()[i].data(), outputs[i].data, outputs[i].bytes);
    ledger_->copied(outputs[i].bytes);
  }
  writer_.unmap();
  return std::move(pooled_);
}

OutputFrame::Made OutputFrame::assemble(const InputFrame& in, std::span<weir_tensor> outputs) {
  const auto& choice = plan_->output_choice;
  pieces_.clear();
  const auto add = [this](Result<gst::TensorPiece> piece) -> Status {
    if (!piece) return piece.error();
    pieces_.push_back(*std::move(piece));
    return ok();
  };
  for (const size_t index : choice.inputs)
    if (auto status = add(input_piece(in, index)); !status) return status.error();
  writer_.unmap();
  const size_t given = plan_->dynamic ? count_given(outputs) : outputs.size();
  const size_t count = choice.empty() ? given : choice.outputs.size();
  for (size_t i = 0; i < count; ++i) {
    const size_t index = choice.empty() ? i : choice.outputs[i];
    if (pooled_ && outputs.size() <= kMemoryLimit) {
      auto* memory = gst_buffer_peek_memory(pooled_.get(), static_cast<guint>(index));
      pieces_.push_back({gst::Ref<GstMemory>::share(memory), pool_.tensors()[index]});
    } else if (auto status = add(output_piece(index, outputs[index])); !status) {
      return status.error();
    } else if (!pieces_.back().memory) {  // no elements, which a static stream cannot hold:
      pieces_.clear();                    // a buffer without memory, for a GAP event
      break;
    }
  }
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  if (auto status = gst::append_tensors(pieces_, out.get(), ledger_); !status)
    return status.error();
  return out;
}

Result<gst::TensorPiece> OutputFrame::input_piece(const InputFrame& in, size_t index) {
  if (index >= in.views().size())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "output-combination names an input that does not exist",
                 .offered = "i" + std::to_string(index)};
  const auto& view = in.views()[index];
  if (view.memory >= 0 && (view.header_bytes > 0) == flexible()) {
    auto* memory = gst_buffer_peek_memory(in.buffer(), static_cast<guint>(view.memory));
    return gst::TensorPiece{gst::Ref<GstMemory>::share(memory), view.spec};
  }
  ledger_->copied(view.payload.size());
  return make_copy(view.spec, view.payload, header());
}

Result<gst::TensorPiece> OutputFrame::output_piece(size_t index, weir_tensor& tensor) {
  if (!tensor.data && tensor.bytes > 0)
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "the engine returned no memory for an output",
                 .offered = "tensor " + std::to_string(index),
                 .needed = "data and a release function"};
  const auto spec = to_spec(model_tensor(tensor.info));
  if (!spec.valid() || spec.bytes() != tensor.bytes)
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "the size of the engine's output does not match its shape",
                 .offered = std::to_string(tensor.bytes) + " bytes",
                 .needed = spec.to_string(),
                 .difference = "tensor " + std::to_string(index)};
  if (!flexible() && spec.shape.is_empty()) return gst::TensorPiece{};
  if (!flexible() && !same_shape(tensor.info, described_[index].info))
    return changed_size(index, tensor.info, plan_->model_outputs[index]);
  if (!flexible() && tensor.release)
    return gst::TensorPiece{gst::Ref<GstMemory>::adopt(adopt(&tensor)), spec};
  ledger_->copied(tensor.bytes);
  const std::span bytes(static_cast<const std::byte*>(tensor.data), tensor.bytes);
  return make_copy(spec, bytes, header());
}

OutputFrame::Made OutputFrame::with_metas(const InputFrame& in, Made made) const {
  if (!made) return made;
  gst_buffer_copy_into(made->get(), in.buffer(), GST_BUFFER_COPY_METADATA, 0,
                       static_cast<gsize>(-1));
  copy_maps(in.buffer(), made->get());
  return made;
}

// A forwarded input keeps its own map, an output gets that of the model's first input. Region maps
// stay unchanged.
void OutputFrame::copy_maps(GstBuffer* in, GstBuffer* out) const {
  const auto of = gst::maps_of(in);
  const auto maps = gst::source_maps(in);
  std::vector<SourceMap> copies(maps.begin(), maps.end());
  if (of == gst::MapsOf::Tensors && copies.size() > 1) {
    const auto& choice = plan_->output_choice;
    const size_t results = choice.empty() ? tensors_.size() : choice.outputs.size();
    const size_t first = plan_->input_choice.empty() ? 0 : plan_->input_choice[0];
    const SourceMap of_input = copies[std::min(first, copies.size() - 1)];
    copies.assign(results, of_input);
    for (size_t i = 0; i < choice.inputs.size(); ++i)
      copies.insert(copies.begin() + static_cast<std::ptrdiff_t>(i),
                    maps[std::min(choice.inputs[i], maps.size() - 1)]);
  }
  gst::set_source_maps(out, std::move(copies), of);
}

}  // namespace weir
