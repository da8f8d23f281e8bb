// Loads a script and queries its tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "python3/python_model.hpp"

#include "python3/filter_names.hpp"
#include "scripts.hpp"

namespace weir::engine {
namespace {

using python::Locked;
using python::Object;

// Splits at single blanks.
std::vector<Object> split_arguments(std::string_view text) {
  std::vector<Object> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    words.push_back(python::text_of(text.substr(0, end)));
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
  if (auto status =
          model->load(Options(request.options, request.n_options).get("custom").value_or(""));
      !status)
    return status.error();
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
  const Object invoke = std::move(invoke_), script = std::move(script_);
}

void PythonModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_ALLOCATES_OUTPUT;
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
  arguments.push_back(python::text_of(method));
  const auto tensors = call("declared_by", std::move(arguments), Code::MODULE_REFUSED);
  if (!tensors) return tensors.error();
  return infos_of(*tensors);
}

Result<PythonModel::Infos> PythonModel::set_inputs(std::span<const weir_tensor_info> inputs) {
  std::vector<Object> arguments;
  arguments.push_back(Object::share(script_.get()));
  add_tensors(inputs, &arguments);
  const auto tensors = call("set_inputs", std::move(arguments), Code::SPEC_MISMATCH);
  if (!tensors) return tensors.error();
  return infos_of(*tensors);
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

void PythonModel::collect_garbage() const {
  // Only a destructor of the script can fail here, and Python has already reported it.
  if (const auto done = call("collect", {}, Code::INVOKE_FAILED); !done) return;
}

Object PythonModel::tensor_of(const weir_tensor_info& info) const {
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
  for (const auto& info : infos) arguments->push_back(tensor_of(info));
}

// `tensors` is ((type, dimensions innermost first), ...), already checked by tensors_of().
Result<PythonModel::Infos> PythonModel::infos_of(const Object& tensors) const {
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
