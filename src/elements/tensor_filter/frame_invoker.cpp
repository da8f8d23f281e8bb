// From buffer to buffer through a model.
#include "elements/tensor_filter/frame_invoker.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>

#include "elements/tensor_filter/model_info.hpp"
#include "gstcpp/tensor_meta.hpp"

namespace weir {
namespace {

Error out_of_memory() {
  return Error{Code::OUT_OF_MEMORY, "no memory for an output buffer", "", "", "", ""};
}

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

void write_header(const TensorSpec& spec, std::span<std::byte> at) {
  TensorHeader header;
  header.spec = spec;
  write_tensor_header(header, at.first<kTensorHeaderBytes>());
}

Status append_copy(const TensorSpec& spec, std::span<const std::byte> bytes, bool with_header,
                   GstBuffer* out) {
  const size_t head = with_header ? kTensorHeaderBytes : 0;
  GstMemory* memory = gst::allocate_memory(head + bytes.size());
  if (!memory) return out_of_memory();
  gst_buffer_append_memory(out, memory);
  const gst::MappedMemory map(memory, GST_MAP_WRITE);
  if (!map) return out_of_memory();
  if (head) write_header(spec, map.bytes());
  if (!bytes.empty()) std::memcpy(map.bytes().data() + head, bytes.data(), bytes.size());
  return ok();
}

}  // namespace

Status FrameInvoker::prepare() {
  describe_tensors(plan_.model_inputs, &inputs_);
  describe_tensors(plan_.model_outputs, &outputs_);
  in_frame_ = {};
  in_frame_.struct_size = sizeof in_frame_;
  in_frame_.pts = in_frame_.duration = in_frame_.deadline = -1;
  out_frame_ = in_frame_;
  in_frame_.n_tensors = static_cast<uint32_t>(inputs_.size());
  in_frame_.tensors = inputs_.data();
  out_frame_.n_tensors = static_cast<uint32_t>(outputs_.size());
  out_frame_.tensors = outputs_.data();
  pool_ = {};
  if (!plan_.outputs_fixed) return ok();
  std::vector<TensorSpec> specs;
  for (const auto& shape : plan_.model_outputs) specs.push_back(to_spec(shape));
  auto pool =
      gst::FramePool::make(std::move(specs), flexible() ? Format::Flexible : Format::Static);
  if (!pool) return pool.error();
  pool_ = *std::move(pool);
  return ok();
}

Status FrameInvoker::adapt_to(const std::vector<ModelShape>& inputs) {
  auto outputs = resolve(session_, inputs, plan_.model_outputs);
  if (!outputs) return outputs.error();
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
  const bool same = std::equal(
      shapes->begin(), shapes->end(), plan_.model_inputs.begin(), plan_.model_inputs.end(),
      [](const auto& a, const auto& b) { return a.type == b.type && a.shape == b.shape; });
  return same ? ok() : adapt_to(*shapes);
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

void FrameInvoker::describe_frame(GstBuffer* in) noexcept {
  const auto time = [](GstClockTime t) {
    return GST_CLOCK_TIME_IS_VALID(t) ? static_cast<int64_t>(t) : -1;
  };
  in_frame_.pts = out_frame_.pts = time(GST_BUFFER_PTS(in));
  in_frame_.duration = out_frame_.duration = time(GST_BUFFER_DURATION(in));
  in_frame_.to_source = gst::to_source(in, first_input(), &to_source_);
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

Result<bool> FrameInvoker::invoke() {
  const auto begin = std::chrono::steady_clock::now();
  auto kept = session_->invoke(in_frame_, out_frame_);
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

Result<gst::Ref<GstBuffer>> FrameInvoker::run(GstBuffer* in) {
  gst::Ref<GstBuffer> pooled;  // outlives its mapping
  struct Unmap {
    FrameInvoker* self;
    ~Unmap() {
      self->writer_.unmap();
      self->reader_.clear();
      self->release_engine_memory();
    }
  } const unmap{this};
  if (auto status = reader_.read(in, plan_.input); !status) return status.error();
  ledger_->copied(reader_.bytes_copied());
  if (auto status = describe_inputs(); !status) return status.error();
  describe_frame(in);
  if (plan_.outputs_fixed) {
    pooled = pool_.acquire();
    if (!pooled) return out_of_memory();
    *pool_allocated_ = pool_.stats().allocated;
    if (auto status = writer_.map(pool_, pooled.get()); !status) return status.error();
    for (size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i].data = writer_.payloads()[i].data();
      outputs_[i].bytes = outputs_[i].capacity = writer_.payloads()[i].size();
    }
  }
  auto kept = invoke();
  if (!kept) return kept.error();
  if (!*kept) return gst::Ref<GstBuffer>{};
  if (plain()) return pooled;
  return assemble(in, pooled);
}

Result<gst::Ref<GstBuffer>> FrameInvoker::assemble(GstBuffer* in, gst::Ref<GstBuffer> pooled) {
  const auto& choice = plan_.output_choice;
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  for (const size_t index : choice.inputs)
    if (auto status = append_input(in, index, out.get()); !status) return status.error();
  writer_.unmap();
  const size_t count = choice.empty() ? outputs_.size() : choice.outputs.size();
  if (choice.inputs.size() + count > kMemoryLimit)
    return Error{Code::LIMIT_EXCEEDED,
                 "output-combination makes more than 16 tensors",
                 std::to_string(choice.inputs.size() + count),
                 "at most 16",
                 "",
                 ""};
  for (size_t i = 0; i < count; ++i) {
    const size_t index = choice.empty() ? i : choice.outputs[i];
    if (pooled && outputs_.size() <= kMemoryLimit) {
      auto* memory = gst_buffer_peek_memory(pooled.get(), static_cast<guint>(index));
      gst_buffer_append_memory(out.get(), gst_memory_ref(memory));
    } else if (auto status = append_output(index, out.get()); !status) {
      return status.error();
    }
  }
  return out;
}

Status FrameInvoker::append_input(GstBuffer* in, size_t index, GstBuffer* out) {
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
    gst_buffer_append_memory(out, gst_memory_ref(memory));
    return ok();
  }
  ledger_->copied(view.payload.size());
  return append_copy(view.spec, view.payload, flexible(), out);
}

Status FrameInvoker::append_output(size_t index, GstBuffer* out) {
  weir_tensor& tensor = outputs_[index];
  if (!tensor.data && tensor.bytes > 0)
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
  if (!flexible() && tensor.release) {
    gst_buffer_append_memory(out, adopt(&tensor));
    return ok();
  }
  ledger_->copied(tensor.bytes);
  const std::span bytes(static_cast<const std::byte*>(tensor.data), tensor.bytes);
  return append_copy(spec, bytes, flexible(), out);
}

}  // namespace weir
