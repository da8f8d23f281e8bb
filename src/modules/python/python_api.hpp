// PythonApi: the functions of Python's stable ABI that scripts need, loaded at run time. Building
// needs no Python header, and one build runs with every Python from 3.9 on.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>

#include "weir/result.hpp"

namespace weir::python {

struct PyObject;  // opaque

// Laid out as in the stable ABI (PEP 688, "Py_buffer").
struct Buffer {
  void* bytes;
  PyObject* owner;
  ptrdiff_t size, item_size;
  int read_only, dimensions;
  char* format;
  ptrdiff_t *shape, *strides, *suboffsets;
  void* internal;
};

#define WEIR_PYTHON_FUNCTIONS(X)                                         \
  X(const char*, Py_GetVersion, ())                                      \
  X(int, Py_IsInitialized, ())                                           \
  X(void, Py_InitializeEx, (int))                                        \
  X(PyObject*, PyEval_SaveThread, ())                                    \
  X(int, PyGILState_Ensure, ())                                          \
  X(void, PyGILState_Release, (int))                                     \
  X(void, Py_IncRef, (PyObject*))                                        \
  X(void, Py_DecRef, (PyObject*))                                        \
  X(PyObject*, PyImport_AddModule, (const char*))                        \
  X(PyObject*, PyModule_GetDict, (PyObject*))                            \
  X(PyObject*, Py_CompileString, (const char*, const char*, int))        \
  X(PyObject*, PyEval_EvalCode, (PyObject*, PyObject*, PyObject*))       \
  X(PyObject*, PyEval_GetBuiltins, ())                                   \
  X(PyObject*, PyDict_New, ())                                           \
  X(PyObject*, PyDict_GetItemString, (PyObject*, const char*))           \
  X(int, PyDict_SetItemString, (PyObject*, const char*, PyObject*))      \
  X(PyObject*, PyObject_Call, (PyObject*, PyObject*, PyObject*))         \
  X(PyObject*, PyObject_GetAttrString, (PyObject*, const char*))         \
  X(PyObject*, PyObject_Type, (PyObject*))                               \
  X(int, PyType_IsSubtype, (PyObject*, PyObject*))                       \
  X(int, PyObject_IsTrue, (PyObject*))                                   \
  X(PyObject*, PyList_New, (ptrdiff_t))                                  \
  X(int, PyList_SetItem, (PyObject*, ptrdiff_t, PyObject*))              \
  X(ptrdiff_t, PyList_Size, (PyObject*))                                 \
  X(PyObject*, PyList_GetItem, (PyObject*, ptrdiff_t))                   \
  X(PyObject*, PyCapsule_New, (void*, const char*, void (*)(PyObject*))) \
  X(void*, PyCapsule_GetPointer, (PyObject*, const char*))               \
  X(PyObject*, PyLong_FromLongLong, (long long))                         \
  X(PyObject*, PyTuple_New, (ptrdiff_t))                                 \
  X(int, PyTuple_SetItem, (PyObject*, ptrdiff_t, PyObject*))             \
  X(ptrdiff_t, PyTuple_Size, (PyObject*))                                \
  X(PyObject*, PyTuple_GetItem, (PyObject*, ptrdiff_t))                  \
  X(PyObject*, PyUnicode_FromStringAndSize, (const char*, ptrdiff_t))    \
  X(PyObject*, PyUnicode_AsUTF8String, (PyObject*))                      \
  X(int, PyBytes_AsStringAndSize, (PyObject*, char**, ptrdiff_t*))       \
  X(long long, PyLong_AsLongLong, (PyObject*))                           \
  X(int, PyObject_GetBuffer, (PyObject*, Buffer*, int))                  \
  X(void, PyBuffer_Release, (Buffer*))                                   \
  X(PyObject*, PyErr_Occurred, ())                                       \
  X(void, PyErr_Clear, ())                                               \
  X(void, PyErr_Fetch, (PyObject**, PyObject**, PyObject**))             \
  X(void, PyErr_NormalizeException, (PyObject**, PyObject**, PyObject**))

struct PythonApi {
#define WEIR_PYTHON_POINTER(result, name, arguments) result(*name) arguments = nullptr;
  WEIR_PYTHON_FUNCTIONS(WEIR_PYTHON_POINTER)
#undef WEIR_PYTHON_POINTER
  void (*Py_SetProgramName)(const wchar_t*) = nullptr;  // null if this Python lacks it
};

// Returns the Python that is already in the process, else loads libpython3: the file in
// WEIR_PYTHON_LIBRARY, or Debian's. It stays loaded until the process exits. ENGINE_NOT_INSTALLED
// gives the install command.
Result<PythonApi> find_python();

}  // namespace weir::python
