// python3 converter: turns any stream into tensors with the class CustomConverter of a Python
// script.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <optional>

#include "frame_script.hpp"
#include "weir/converter.hpp"

namespace {

using weir::python::Object;
using weir::python::PyObject;

constexpr char kConverting[] = R"py(
import gc
import numpy
from weir_scripts import DTYPES, is_a, to_tensor

def collect():
    gc.collect()

def check_array(index, shape, array):
    kind, dims = to_tensor(shape)
    dtype = DTYPES[kind]
    if not is_a(numpy.ndarray, array):
        raise TypeError(f"array {index} is not a NumPy array but {type(array).__name__}")
    array = numpy.asarray(array)  # a subclass may report another type or size than its memory has
    if array.dtype not in (numpy.uint8, dtype):
        raise TypeError(f"array {index} is of {array.dtype}: pass bytes, array.view(numpy.uint8)")
    needed = dtype.itemsize
    for d in dims:
        needed *= d
    if array.nbytes != needed:
        raise ValueError(f"array {index} has {array.nbytes} bytes: its TensorShape {list(dims)} of "
                         f"{dtype} has {needed}")
    return kind, dims, numpy.ascontiguousarray(array)

def convert(script, arrays):
    made = script.convert(arrays)
    if made is None:
        return None
    if not is_a(tuple, made) or len(made) != 4:
        raise TypeError("convert returns (tensors_info, out_array, rate_n, rate_d), not "
                        + (f"{len(made)} values" if is_a(tuple, made) else type(made).__name__))
    shapes, arrays, rate_n, rate_d = made
    shapes, arrays = list(shapes), list(arrays)  # read once
    if not shapes and not arrays:
        return None
    if len(shapes) != len(arrays):
        raise ValueError(f"{len(shapes)} TensorShapes for {len(arrays)} arrays")
    tensors = tuple(check_array(i, *pair) for i, pair in enumerate(zip(shapes, arrays)))
    rate_n, rate_d = int(rate_n), int(rate_d)
    if not (0 <= rate_n < 1 << 31 and 1 <= rate_d < 1 << 31):
        raise ValueError(f"{rate_n}/{rate_d} is not a frame rate, which is 0/1 or more")
    return rate_n, rate_d, tensors
)py";

std::string get_path(const weir::Options& options) {
  const auto path = options.get("script");
  if (!path)
    throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                         .what = "no script is set",
                         .needed = "a Python file",
                         .fix = "tensor_converter mode=custom-script:/path/to/script.py"});
  return std::string(*path);
}

class Script {
 public:
  explicit Script(const weir::Options& options)
      : script_({"CustomConverter", "convert", "weir_converting", kConverting}, get_path(options)) {
  }

  std::vector<weir_tensor_info> configure(std::string_view) { return {}; }

  bool convert(const weir_frame& frame, weir::ConverterOutput& output) {
    bool has_frame = false;
    script_.with_frame([&](const Object& owner) {
      const Object made =
          script_.call("convert", script_.instance(), script_.make_byte_arrays(frame, owner));
      has_frame = api_.PyObject_IsTrue(made.get()) == 1;
      if (has_frame) fill(made.get(), output);
    });
    return has_frame;
  }

  std::optional<std::pair<int32_t, int32_t>> rate() const noexcept { return rate_; }

 private:
  // `made` is (rate_n, rate_d, ((type, dimensions, array), ...)), already checked by kConverting.
  void fill(PyObject* made, weir::ConverterOutput& output) {
    const auto number = [&](ptrdiff_t i) {
      return static_cast<int32_t>(api_.PyLong_AsLongLong(api_.PyTuple_GetItem(made, i)));
    };
    rate_ = {number(0), number(1)};
    PyObject* tensors = api_.PyTuple_GetItem(made, 2);
    for (ptrdiff_t i = 0; i < api_.PyTuple_Size(tensors); ++i)
      add(api_.PyTuple_GetItem(tensors, i), output);
  }

  void add(PyObject* tensor, weir::ConverterOutput& output) {
    weir_tensor_info info{};
    info.type = static_cast<uint32_t>(api_.PyLong_AsLongLong(api_.PyTuple_GetItem(tensor, 0)));
    PyObject* dims = api_.PyTuple_GetItem(tensor, 1);
    info.rank = static_cast<uint32_t>(api_.PyTuple_Size(dims));  // at most 16
    for (uint32_t i = 0; i < info.rank; ++i)
      info.shape[info.rank - 1 - i] = api_.PyLong_AsLongLong(api_.PyTuple_GetItem(dims, i));
    info.batch_axis = WEIR_NO_BATCH_AXIS;
    const weir::python::HeldBuffer from(api_.PyTuple_GetItem(tensor, 2),
                                        weir::python::kSimpleBuffer);
    if (!from) weir::python::FrameScript::throw_exception(weir::Code::INVOKE_FAILED);
    const auto to = output.add(info);
    if (to.size() != static_cast<size_t>(from->size))
      throw weir::Failure(weir::Error{.code = weir::Code::FRAME_SIZE,
                                      .what = "the size of an array differs from its TensorShape",
                                      .offered = std::to_string(from->size) + " bytes",
                                      .needed = std::to_string(to.size()) + " bytes",
                                      .difference = {},
                                      .fix = {}});
    std::memcpy(to.data(), from->bytes, to.size());
  }

  weir::python::FrameScript script_;
  const weir::python::PythonApi& api_ = script_.api();
  std::optional<std::pair<int32_t, int32_t>> rate_;
};

}  // namespace

WEIR_CONVERTER(Script, "python3", "python", "application/octet-stream",
               R"([{"name":"script","type":"file","default":"",)"
               R"("help":"a Python file with a class CustomConverter"}])")
