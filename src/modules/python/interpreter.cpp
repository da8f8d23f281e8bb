// SPDX-License-Identifier: LGPL-2.1-or-later
#include "interpreter.hpp"

#include <mutex>

namespace weir::python {
namespace {

constexpr int kFileInput = 257;  // Py_file_input

PythonApi api;  // written once, before a pointer to it is published

// Describes an exception and where it was raised, in existing files only: not in our own lines.
constexpr char kExceptions[] = R"py(
import os, traceback

def describe(kind, value, trace):
    what = "".join(traceback.format_exception_only(kind, value)).strip()
    where = [f"{f.filename}:{f.lineno} in {f.name}: {f.line}" for f in traceback.extract_tb(trace)
             if os.path.exists(f.filename)]
    # A text of Python may hold what UTF-8 has no place for.
    texts = (t.encode("utf-8", "backslashreplace").decode() for t in (what, "; ".join(where)))
    return *texts, isinstance(value, MemoryError)
)py";

std::string utf8(PyObject* text) {
  const Object bytes = Object::adopt(text ? api.PyUnicode_AsUTF8String(text) : nullptr);
  char* data = nullptr;
  ptrdiff_t size = 0;
  if (!bytes || api.PyBytes_AsStringAndSize(bytes.get(), &data, &size) != 0) {
    api.PyErr_Clear();
    return "";
  }
  return {data, static_cast<size_t>(size)};
}

void forget_exception() {
  PyObject *kind = nullptr, *value = nullptr, *trace = nullptr;
  api.PyErr_Fetch(&kind, &value, &trace);
  const Object owned[] = {Object::adopt(kind), Object::adopt(value), Object::adopt(trace)};
}

Object none_if_null(PyObject* object) {
  return object ? Object::adopt(object)
                : Object::share(api.PyDict_GetItemString(api.PyEval_GetBuiltins(), "None"));
}

// Null, with the exception set, on failure.
Object called(PyObject* callable, std::vector<Object> arguments) {
  Object tuple = Object::adopt(api.PyTuple_New(static_cast<ptrdiff_t>(arguments.size())));
  for (size_t i = 0; tuple && i < arguments.size(); ++i) {
    if (!arguments[i]) return {};  // memory ran out when it was created
    api.PyTuple_SetItem(tuple.get(), static_cast<ptrdiff_t>(i), arguments[i].release());
  }
  return Object::adopt(tuple ? api.PyObject_Call(callable, tuple.get(), nullptr) : nullptr);
}

// Returns the dict of one of our modules, borrowed; null with the exception set on failure.
PyObject* load_names(const char* name, const char* source) {
  PyObject* module = api.PyImport_AddModule(name);
  PyObject* names = module ? api.PyModule_GetDict(module) : nullptr;
  if (!names || api.PyDict_GetItemString(names, "weir_is_ready")) return names;
  api.PyDict_SetItemString(names, "__builtins__", api.PyEval_GetBuiltins());
  const Object code = Object::adopt(api.Py_CompileString(source, name, kFileInput));
  const Object done = Object::adopt(code ? api.PyEval_EvalCode(code.get(), names, names) : nullptr);
  if (!done) return nullptr;
  api.PyDict_SetItemString(names, "weir_is_ready", done.get());
  return names;
}

// Imports NumPy early for an error that names it when it is missing.
Status import_numpy() {
  const Locked lock;
  const auto found = module_of_ours("weir_numpy", "import numpy");
  if (found) return ok();
  // A NumPy for another Python fails to import too; the exception explains that.
  return Error{.code = Code::ENGINE_NOT_INSTALLED,
               .what = "NumPy is not installed for this Python",
               .offered = found.error().what,
               .needed = "NumPy for this version of Python",
               .fix = "apt-get install python3-numpy"};
}

Status start() {
  auto found = find_python();
  if (!found) return found.error();
  api = *found;
  if (!api.Py_IsInitialized()) {
    // Otherwise the first python3 in PATH determines where Python looks for modules.
    if (api.Py_SetProgramName) api.Py_SetProgramName(L"/usr/bin/python3");
    api.Py_InitializeEx(0);  // 0: leave signal handlers to the program
    api.PyEval_SaveThread();
  }
  return import_numpy();
}

}  // namespace

Result<const PythonApi*> interpreter() {
  static std::once_flag once;
  static Status started = ok();
  std::call_once(once, [] { started = start(); });
  if (!started) return started.error();
  return &api;
}

Locked::Locked() : state_(api.PyGILState_Ensure()) {}
Locked::~Locked() {
  api.PyGILState_Release(state_);
}

Object Object::share(PyObject* object) {
  if (object) api.Py_IncRef(object);
  return Object(object);
}
Object::~Object() {
  if (object_) api.Py_DecRef(object_);
}

Result<PyObject*> module_of_ours(const char* name, const char* source) {
  PyObject* names = load_names(name, source);
  if (!names) return take_exception(Code::INTERNAL);
  return names;
}

Result<Object> call(PyObject* names, const char* function, std::vector<Object> arguments,
                    Code code) {
  PyObject* callable = api.PyDict_GetItemString(names, function);
  if (!callable)
    return Error{
        .code = Code::INTERNAL, .what = "a built-in function is missing", .offered = function};
  Object result = called(callable, std::move(arguments));
  if (!result) return take_exception(code);
  return result;
}

Object make_text(std::string_view text) {
  return Object::adopt(
      api.PyUnicode_FromStringAndSize(text.data(), static_cast<ptrdiff_t>(text.size())));
}

HeldBuffer::HeldBuffer(PyObject* object, int flags)
    : held_(api.PyObject_GetBuffer(object, &buffer_, flags) == 0) {}
HeldBuffer::~HeldBuffer() {
  if (held_) api.PyBuffer_Release(&buffer_);
}

Error take_exception(Code code) {
  PyObject *kind = nullptr, *value = nullptr, *trace = nullptr;
  api.PyErr_Fetch(&kind, &value, &trace);
  if (!kind) return {.code = code, .what = "the script failed without an exception"};
  api.PyErr_NormalizeException(&kind, &value, &trace);
  std::vector<Object> parts;
  for (PyObject* part : {kind, value, trace}) parts.push_back(none_if_null(part));
  PyObject* names = load_names("weir_exceptions", kExceptions);
  PyObject* describe = names ? api.PyDict_GetItemString(names, "describe") : nullptr;
  const Object words = describe ? called(describe, std::move(parts)) : Object();
  if (!words) {
    forget_exception();
    return {.code = code, .what = "the script failed, and its exception cannot be described"};
  }
  if (api.PyObject_IsTrue(api.PyTuple_GetItem(words.get(), 2)) == 1) code = Code::OUT_OF_MEMORY;
  return {.code = code,
          .what = "the script failed: " + utf8(api.PyTuple_GetItem(words.get(), 0)),
          .offered = utf8(api.PyTuple_GetItem(words.get(), 1))};
}

}  // namespace weir::python
