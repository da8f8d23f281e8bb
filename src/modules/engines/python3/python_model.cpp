// SPDX-License-Identifier: LGPL-2.1-or-later
#include "python3/python_model.hpp"

#include "scripts.hpp"

namespace weir::engine {
namespace {

// The Python code that calls a script's CustomFilter. A tensor here is (the number of its type in
// abi.h, dimensions innermost first).
constexpr char kFilterNames[] = R"py(
import gc, math, sys
import numpy
from weir_scripts import DTYPES, TensorShape, is_a, to_tensor

MOST_TENSORS = 256

def has(script, name):
    return callable(getattr(script, name, None))

# Does the script compute its outputs from given inputs (setInputDim), or declare both?
def takes_input_shapes(script):
    if not has(script, "invoke"):
        raise AttributeError("the class CustomFilter has no method invoke(self, input_array)")
    if has(script, "setInputDim"):
        return True
    if has(script, "getInputDim") and has(script, "getOutputDim"):
        return False
    raise AttributeError("the class CustomFilter has neither setInputDim(self, input_dims) nor both "
                         "getInputDim(self) and getOutputDim(self)")

def to_tensors(method, shapes):
    if not is_a((list, tuple), shapes):
        raise TypeError(f"{method} must return a list of TensorShape, not {type(shapes).__name__}")
    shapes = list(shapes)  # read once: a subclass may have another length the next time
    if not 1 <= len(shapes) <= MOST_TENSORS:
        raise ValueError(f"{method} returned {len(shapes)} TensorShapes: 1 to {MOST_TENSORS} can be")
    for i, shape in enumerate(shapes):
        if not (has(shape, "getDims") and has(shape, "getType")):
            raise TypeError(f"{method}: entry {i} of its list is not a TensorShape but "
                            f"{type(shape).__name__}")
    return tuple(to_tensor(shape) for shape in shapes)

def declared_by(script, method):
    return to_tensors(method, getattr(script, method)())

def set_inputs(script, *tensors):
    shapes = [TensorShape(list(dims), DTYPES[number]) for number, dims in tensors]
    return to_tensors("setInputDim", script.setInputDim(shapes))

def describe(tensor):
    number, dims = tensor
    return f"{DTYPES[number]} {':'.join(map(str, dims))}"

# One output, dense; or what is wrong with it.
def dense(i, array, tensor):
    number, dims = tensor
    if not is_a(numpy.ndarray, array):
        raise TypeError(f"output {i} is not a NumPy array but {type(array).__name__}, needed is "
                        f"{describe(tensor)}")
    array = numpy.asarray(array)  # a subclass may report another type or size than its memory has
    if array.dtype != DTYPES[number]:
        raise TypeError(f"output {i} is an array of {array.dtype}, needed is {describe(tensor)}: "
                        f"array.astype(numpy.{DTYPES[number]})")
    needed = DTYPES[number].itemsize
    for dim in dims:
        needed *= dim
    if array.nbytes != needed:
        raise ValueError(f"output {i} has {array.nbytes} bytes, shape {array.shape}, needed are "
                         f"{needed}: {describe(tensor)}")
    return numpy.ascontiguousarray(array, DTYPES[number])

# The arrays that invoke returned; none if it has no result.
def listed(made, tensors):
    if made is None:
        return []
    if not is_a((list, tuple), made):
        raise TypeError(f"invoke must return a list of NumPy arrays, not {type(made).__name__}")
    made = list(made)
    if made and len(made) != len(tensors):
        raise ValueError(f"invoke returned {len(made)} arrays, needed are {len(tensors)}: "
                         f"{', '.join(map(describe, tensors))}")
    return made

# What invoke returned, as a tuple of dense arrays; empty if it has no result.
def checked(made, *tensors):
    made = listed(made, tensors)
    if all(is_a(numpy.ndarray, array) and array.size == 0 for array in made):
        return ()
    return tuple(dense(i, *pair) for i, pair in enumerate(zip(made, tensors)))

# An output with the shape of its array: rows of the declared dimensions in an array of one.
def sized(i, array, tensor):
    if not is_a(numpy.ndarray, array):
        raise TypeError(f"output {i} is not a NumPy array but {type(array).__name__}")
    number, (*row, _) = tensor
    shape = numpy.asarray(array).shape or (1,)
    length = math.prod(row)
    if len(shape) == 1 and row and shape[0] % length == 0:
        shape = (shape[0] // length, *reversed(row))
    return number, tuple(reversed(shape))

# The same with outputs whose sizes each call decides: (shapes, arrays).
def checked_sizes(made, *tensors):
    made = listed(made, tensors)
    if not made:
        return ()
    shapes = tuple(sized(i, *pair) for i, pair in enumerate(zip(made, tensors)))
    return shapes, tuple(dense(i, *pair) for i, pair in enumerate(zip(made, shapes)))

def fresh():
    return [numpy.empty(1)]

# References to an array that owns its memory, those of the call among them; 0 for any other. Of a
# subclass nothing is known: it may report to own what it does not.
def references(array):
    owns = type(array) is numpy.ndarray and array.base is None and array.flags.owndata
    return sys.getrefcount(array) if owns else 0

# The same of the list that it came in.
def references_of_list(made):
    return sys.getrefcount(made)

# Code that reaches it anyway can only read it.
def lock(array):
    array.flags.writeable = False

def collect():
    gc.collect()
)py";

using python::Locked;
using python::Object;

// Splits at single blanks.
std::vector<Object> split_arguments(std::string_view text) {
  std::vector<Object> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    words.push_back(python::make_text(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

Error one_script(const weir_open& request) {
  return {.code = Code::MODEL_UNSUPPORTED,
          .what = "a filter in Python is one script",
          .offered = std::to_string(request.n_models) + " files",
          .needed = "one",
          .fix = "tensor_filter framework=python3 model=filter.py"};
}

}  // namespace

Result<std::unique_ptr<PythonModel>> PythonModel::open(const weir_open& request) {
  if (request.n_models != 1) return one_script(request);
  const auto api = python::interpreter();
  if (!api) return api.error();
  std::unique_ptr<PythonModel> model(new PythonModel(**api, request.paths[0]));
  const Options options(request.options, request.n_options);
  model->decides_sizes_ = options.get("invoke-dynamic") == "true";
  if (auto status = model->load(options.get("custom").value_or("")); !status) return status.error();
  return model;
}

Status PythonModel::load(std::string_view arguments) {
  const Locked lock;
  auto numpy = python::Numpy::open(api_);
  if (!numpy) return numpy.error();
  numpy_ = *numpy;
  if (const auto names = python::script_names(); !names) return names.error();
  const auto names = python::module_of_ours("weir_filtering", kFilterNames);
  if (!names) return names.error();
  names_ = *names;
  auto script = python::load_script(path_, "CustomFilter", split_arguments(arguments));
  if (!script) return script.error();
  script_ = *std::move(script);
  std::vector<Object> self;
  self.push_back(Object::share(script_.get()));
  const auto takes_shapes = call("takes_input_shapes", std::move(self), Code::MODULE_REFUSED);
  if (!takes_shapes) return takes_shapes.error();
  takes_input_shapes_ = api_.PyObject_IsTrue(takes_shapes->get()) == 1;
  invoke_ = Object::adopt(api_.PyObject_GetAttrString(script_.get(), "invoke"));
  if (!invoke_) return python::take_exception(Code::MODULE_REFUSED);
  if (auto status = measure(); !status) return status;
  if (takes_input_shapes_) return ok();
  for (const bool input : {true, false}) {
    auto infos = declared_by(input ? "getInputDim" : "getOutputDim");
    if (!infos) return infos.error();
    (input ? inputs_ : outputs_) = *std::move(infos);
  }
  open_rows(&outputs_);
  return ok();
}

// The reference counts differ between versions of Python, so they are measured.
Status PythonModel::measure() {
  const auto fresh = call("fresh", {}, Code::INTERNAL);
  if (!fresh) return fresh.error();
  list_references_ = count("references_of_list", fresh->get());
  // Held in the same way as in PythonSession::write().
  const Object array = Object::share(api_.PyList_GetItem(fresh->get(), 0));
  const python::HeldBuffer buffer(array.get(), python::kDenseWithFormat);
  array_references_ = count("references", array.get());
  return ok();
}

long long PythonModel::count(const char* function, python::PyObject* object) const {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(object));
  const auto number = call(function, std::move(arguments), Code::INTERNAL);
  return number ? api_.PyLong_AsLongLong(number->get()) : -1;
}

bool PythonModel::is_only_list(const Object& made) const {
  return count("references_of_list", made.get()) == list_references_;
}

bool PythonModel::give_away(python::PyObject* array) const {
  if (count("references", array) != array_references_) return false;
  std::vector<Object> arguments;
  arguments.push_back(Object::share(array));
  return bool(call("lock", std::move(arguments), Code::INTERNAL));
}

PythonModel::~PythonModel() {
  const Locked lock;
  const Object invoke = std::move(invoke_);
  python::unload_script(std::move(script_));
}

void PythonModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_ALLOCATES_OUTPUT;
  if (decides_sizes_) info->flags |= WEIR_MODEL_DYNAMIC_OUTPUT;
  if (takes_input_shapes_) info->flags |= WEIR_MODEL_EMPTY_INPUT;
  info->inputs = inputs_.data();
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->outputs = outputs_.data();
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->alignment = 8;  // size of the largest element type
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = info->max_in_flight = info->preferred_batch = 1;
}

Result<Object> PythonModel::call(const char* function, std::vector<Object> arguments,
                                 Code code) const {
  return python::call(names_, function, std::move(arguments), code);
}

Result<PythonModel::Infos> PythonModel::declared_by(const char* method) {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(script_.get()));
  arguments.push_back(python::make_text(method));
  const auto tensors = call("declared_by", std::move(arguments), Code::MODULE_REFUSED);
  if (!tensors) return tensors.error();
  return to_infos(*tensors);
}

Result<PythonModel::Infos> PythonModel::set_inputs(std::span<const weir_tensor_info> inputs) {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(script_.get()));
  add_tensors(inputs, &arguments);
  const auto tensors = call("set_inputs", std::move(arguments), Code::SPEC_MISMATCH);
  if (!tensors) return tensors.error();
  auto outputs = to_infos(*tensors);
  if (outputs) open_rows(&*outputs);
  return outputs;
}

// Leaves the outermost dimension open where each invoke decides it.
void PythonModel::open_rows(Infos* outputs) const {
  if (!decides_sizes_) return;
  for (auto& info : *outputs) info.shape[0] = -1;
}

Result<Object> PythonModel::invoke(Object arrays) {
  Object arguments = Object::adopt(api_.PyTuple_New(1));
  if (arguments) api_.PyTuple_SetItem(arguments.get(), 0, arrays.release());
  Object made = Object::adopt(
      arguments ? api_.PyObject_Call(invoke_.get(), arguments.get(), nullptr) : nullptr);
  if (!made) return python::take_exception(Code::INVOKE_FAILED);
  return made;
}

Result<Object> PythonModel::checked(const Object& made,
                                    std::span<const weir_tensor_info> outputs) const {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(made.get()));
  add_tensors(outputs, &arguments);
  return call("checked", std::move(arguments), Code::INVOKE_FAILED);
}

Result<PythonModel::Sized> PythonModel::checked_sizes(
    const Object& made, std::span<const weir_tensor_info> outputs) const {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(made.get()));
  add_tensors(outputs, &arguments);
  const auto checked = call("checked_sizes", std::move(arguments), Code::INVOKE_FAILED);
  if (!checked) return checked.error();
  if (api_.PyTuple_Size(checked->get()) == 0) return Sized{};
  auto infos = to_infos(Object::share(api_.PyTuple_GetItem(checked->get(), 0)));
  if (!infos) return infos.error();
  return Sized{*std::move(infos), Object::share(api_.PyTuple_GetItem(checked->get(), 1))};
}

void PythonModel::collect_garbage() const {
  // Only a destructor of the script can fail here, and Python has already reported it.
  if (const auto done = call("collect", {}, Code::INVOKE_FAILED); !done) return;
}

Object PythonModel::make_tensor(const weir_tensor_info& info) const {
  Object dims = Object::adopt(api_.PyTuple_New(info.rank));
  for (uint32_t i = 0; dims && i < info.rank; ++i)
    api_.PyTuple_SetItem(dims.get(), i, api_.PyLong_FromLongLong(dimension(info, i)));
  Object tensor = Object::adopt(api_.PyTuple_New(2));
  if (!tensor) return tensor;
  api_.PyTuple_SetItem(tensor.get(), 0, api_.PyLong_FromLongLong(info.type));
  api_.PyTuple_SetItem(tensor.get(), 1, dims.release());
  return tensor;
}

void PythonModel::add_tensors(std::span<const weir_tensor_info> infos,
                              std::vector<Object>* arguments) const {
  for (const auto& info : infos) arguments->push_back(make_tensor(info));
}

// `tensors` is ((type, dimensions innermost first), ...), already checked by to_tensors().
Result<PythonModel::Infos> PythonModel::to_infos(const Object& tensors) const {
  Infos infos(static_cast<size_t>(api_.PyTuple_Size(tensors.get())));
  for (size_t t = 0; t < infos.size(); ++t) {
    auto& info = infos[t] = open_tensor_info();
    python::PyObject* tensor = api_.PyTuple_GetItem(tensors.get(), static_cast<ptrdiff_t>(t));
    python::PyObject* dims = api_.PyTuple_GetItem(tensor, 1);
    info.type = static_cast<uint32_t>(api_.PyLong_AsLongLong(api_.PyTuple_GetItem(tensor, 0)));
    info.rank = static_cast<uint32_t>(api_.PyTuple_Size(dims));
    for (uint32_t i = 0; i < info.rank; ++i)
      info.shape[info.rank - 1 - i] = api_.PyLong_AsLongLong(api_.PyTuple_GetItem(dims, i));
  }
  return infos;
}

}  // namespace weir::engine
