// SPDX-License-Identifier: LGPL-2.1-or-later
#include "python3/python_session.hpp"

#include <algorithm>

#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

using python::Buffer;
using python::HeldBuffer;
using python::kDenseWithFormat;
using python::Locked;
using python::Object;
using python::PyObject;

// The format characters of Python's module struct, by kind; the machine determines their size.
std::string_view get_formats(uint32_t type) {
  switch (type) {
    case WEIR_INT8:
    case WEIR_INT16:
    case WEIR_INT32:
    case WEIR_INT64:
      return "bhilq";
    case WEIR_UINT8:
    case WEIR_UINT16:
    case WEIR_UINT32:
    case WEIR_UINT64:
      return "BHILQ";
    default:
      return "efd";
  }
}

bool has_type(const Buffer& buffer, uint32_t type) {
  return buffer.format && buffer.format[0] && !buffer.format[1] &&
         get_formats(type).find(buffer.format[0]) != std::string_view::npos &&
         buffer.item_size == static_cast<ptrdiff_t>(element_bytes(type));
}

bool needs_memory(const weir_frame& out) {
  return std::any_of(out.tensors, out.tensors + out.n_tensors,
                     [](const weir_tensor& tensor) { return !tensor.data; });
}

Error kept_its_input() {
  return {
      .code = Code::INVOKE_FAILED,
      .what = "the script keeps an array of its input, whose memory is only valid during invoke",
      .needed = "a copy",
      .fix = "array.copy()"};
}

}  // namespace

PythonSession::PythonSession(PythonModel& model)
    : model_(model), api_(model.api()), outputs_(model.outputs()) {}

Result<std::unique_ptr<PythonSession>> PythonSession::create(PythonModel& model,
                                                             std::span<const weir_option>) {
  return std::unique_ptr<PythonSession>(new PythonSession(model));
}

Status PythonSession::resolve(std::span<const weir_tensor_info> in,
                              std::span<weir_tensor_info> out) {
  if (!model_.takes_input_shapes()) return ok();
  const Locked lock;
  auto outputs = model_.set_inputs(in);
  if (!outputs) return outputs.error();
  if (out.size() < outputs->size())
    return Error{.code = Code::MODEL_DIFFERS,
                 .what = "setInputDim returned more tensors than there is room for",
                 .offered = std::to_string(outputs->size()),
                 .needed = "at most " + std::to_string(out.size())};
  outputs_ = *std::move(outputs);
  std::copy(outputs_.begin(), outputs_.end(), out.begin());
  return ok();
}

Result<bool> PythonSession::invoke(const weir_frame& in, weir_frame& out) {
  if (kept_) return *kept_;
  if (out.n_tensors != outputs_.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the frame and the script have different numbers of outputs",
                 .offered = std::to_string(out.n_tensors),
                 .needed = std::to_string(outputs_.size()),
                 .difference = "number of tensors"};
  for (uint32_t i = 0; i < in.n_tensors; ++i)
    if (element_bytes(in.tensors[i].info.type) == 0)
      return Error{.code = Code::FORMAT_UNSUPPORTED, .what = "an input has an unknown type"};
    else if (auto status = check_memory(in.tensors[i], i, "input"); !status)
      return status.error();
  const Locked lock;
  python::FrameHold hold(api_);
  if (!hold.owner()) return python::take_exception(Code::OUT_OF_MEMORY);
  auto kept = run(in, out, hold.owner());
  if (hold.let_go() || hold.keep(in)) return kept;
  model_.collect_garbage();  // a reference cycle may hold the array
  if (hold.is_gone()) return kept;
  kept_ = kept_its_input();
  return *kept_;
}

Result<bool> PythonSession::run(const weir_frame& in, weir_frame& out, const Object& owner) {
  auto arrays = make_arrays(in, owner);
  if (!arrays) return arrays.error();
  const auto made = model_.invoke(*std::move(arrays));
  if (!made) return made.error();
  return model_.decides_sizes() ? write_sized(*made, out) : write(*made, out);
}

Result<Object> PythonSession::make_arrays(const weir_frame& in, const Object& owner) const {
  Object list = Object::adopt(api_.PyList_New(in.n_tensors));
  for (uint32_t i = 0; list && i < in.n_tensors; ++i) {
    const auto& tensor = in.tensors[i];
    const auto count = static_cast<int64_t>(tensor.bytes / element_bytes(tensor.info.type));
    Object array = model_.numpy().view(tensor.info.type, tensor.data, count, owner);
    if (!array) return python::take_exception(Code::OUT_OF_MEMORY);
    api_.PyList_SetItem(list.get(), i, array.release());
  }
  if (!list) return python::take_exception(Code::OUT_OF_MEMORY);
  return list;
}

// Valid dense arrays are written straight into the frame; Python converts all others or finds their
// error.
Result<bool> PythonSession::write(const Object& made, weir_frame& out) const {
  const auto count = static_cast<ptrdiff_t>(out.n_tensors);
  const auto write_one = [&](PyObject* array, bool ours, ptrdiff_t i) {
    return write(Object::share(array), ours, static_cast<size_t>(i), out.tensors + i);
  };
  const bool counted = api_.PyList_Size(made.get()) == count;
  const bool ours = counted && needs_memory(out) && model_.is_only_list(made);
  ptrdiff_t first = 0;  // first output that is not yet written
  for (; counted && first < count; ++first) {
    const auto done = write_one(api_.PyList_GetItem(made.get(), first), ours, first);
    if (!done) return done.error();
    if (!*done) break;
  }
  if (counted && first == count) return true;
  api_.PyErr_Clear();
  const auto arrays = model_.checked(made, outputs_);
  if (!arrays) return arrays.error();
  if (api_.PyTuple_Size(arrays->get()) == 0) return false;
  for (; first < count; ++first) {
    const auto done = write_one(api_.PyTuple_GetItem(arrays->get(), first), false, first);
    if (!done) return done.error();
    if (!*done) return python::take_exception(Code::INVOKE_FAILED);
  }
  return true;
}

Result<bool> PythonSession::write_sized(const Object& made, weir_frame& out) const {
  const auto sized = model_.checked_sizes(made, outputs_);
  if (!sized) return sized.error();
  for (size_t i = 0; i < sized->infos.size(); ++i) {
    const HeldBuffer buffer(api_.PyTuple_GetItem(sized->arrays.get(), static_cast<ptrdiff_t>(i)),
                            kDenseWithFormat);
    if (!buffer) return python::take_exception(Code::INVOKE_FAILED);
    if (auto status = write_output(sized->infos[i], buffer->bytes, i, &out.tensors[i]); !status)
      return status.error();
  }
  return !sized->infos.empty();
}

// Returns false when it is not a dense array of that type and size.
Result<bool> PythonSession::write(const Object& array, bool ours, size_t index,
                                  weir_tensor* tensor) const {
  const auto& info = outputs_[index];
  if (!is_array(array)) return false;
  const HeldBuffer buffer(array.get(), kDenseWithFormat);
  const uint64_t needed = tensor_bytes(info).value_or(0);
  if (!buffer || !has_type(*buffer, info.type) || static_cast<uint64_t>(buffer->size) != needed)
    return false;
  void* const data = buffer->bytes;
  if (!tensor->data && ours && hand_over(array, data, tensor)) {
    const char* name = tensor->info.name;
    tensor->info = info;
    tensor->info.name = name;
    tensor->bytes = tensor->capacity = needed;
    return true;
  }
  if (auto status = write_output(info, data, index, tensor); !status) return status.error();
  return true;
}

// Checks the real type: a script can define the property __class__ of an object.
bool PythonSession::is_array(const Object& object) const {
  if (!object) return false;
  const Object type = Object::adopt(api_.PyObject_Type(object.get()));
  return api_.PyType_IsSubtype(type.get(), model_.numpy().array_type()) != 0;
}

// The frame keeps the array until its memory is freed, on any thread.
bool PythonSession::hand_over(const Object& array, void* data, weir_tensor* tensor) const {
  if (!model_.give_away(array.get())) return false;
  tensor->data = data;
  tensor->owner = Object::share(array.get()).release();
  tensor->release = [](void* kept) {
    const python::PythonApi& api = **python::interpreter();  // never fails: Python made the array
    if (!api.Py_IsInitialized()) return;                     // the process is exiting
    const Locked lock;
    const Object last = Object::adopt(static_cast<PyObject*>(kept));
  };
  return true;
}

}  // namespace weir::engine
