// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frame_script.hpp"

#include "scripts.hpp"

namespace weir::python {

FrameScript::FrameScript(const Kind& kind, std::string path)
    : api_(*value_or_throw(interpreter())), method_(kind.method), path_(std::move(path)) {
  const Locked lock;
  value_or_throw(script_names());
  numpy_ = value_or_throw(Numpy::open(api_));
  names_ = value_or_throw(module_of_ours(kind.module_name, kind.functions));
  script_ = value_or_throw(load_script(path_, kind.class_name, {}));
}

FrameScript::~FrameScript() {
  const Locked lock;
  unload_script(std::move(script_));
}

void FrameScript::throw_exception(Code code) {
  throw Failure(take_exception(code));
}

template <class ArrayOf>
Object FrameScript::make_list(const weir_frame& frame, ArrayOf&& make_array) const {
  Object arrays = Object::adopt(api_.PyList_New(frame.n_tensors));
  if (!arrays) throw_exception(Code::OUT_OF_MEMORY);
  for (uint32_t i = 0; i < frame.n_tensors; ++i) {
    Object array = make_array(frame.tensors[i]);
    if (!array) throw_exception(Code::OUT_OF_MEMORY);
    api_.PyList_SetItem(arrays.get(), i, array.release());
  }
  return arrays;
}

Object FrameScript::make_arrays(const weir_frame& frame, const Object& owner) const {
  return make_list(frame, [&](const weir_tensor& tensor) {
    const auto count = tensor.bytes / element_bytes(tensor.info.type);
    return numpy_.view(tensor.info.type, tensor.data, static_cast<int64_t>(count), owner);
  });
}

Object FrameScript::make_byte_arrays(const weir_frame& frame, const Object& owner) const {
  static char nothing = 0;
  return make_list(frame, [&](const weir_tensor& tensor) {
    return numpy_.view(WEIR_UINT8, tensor.bytes > 0 ? tensor.data : &nothing,
                       static_cast<int64_t>(tensor.bytes), owner);
  });
}

void FrameScript::release(FrameHold* hold) {
  if (hold->let_go()) return;
  call("collect");  // a reference cycle may hold the array
  if (hold->is_gone()) return;
  // The array points to memory that is about to be freed: never run the script again.
  kept_ = Error{.code = Code::INVOKE_FAILED,
                .what = std::string("the script keeps an array of its input, whose memory is gone "
                                    "after ") +
                        method_,
                .offered = path_,
                .needed = "a copy",
                .fix = "array.copy()"};
  throw Failure(*kept_);
}

}  // namespace weir::python
