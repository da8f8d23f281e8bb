// The process's single Python interpreter, for modules that run scripts on streaming threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "python_api.hpp"

namespace weir::python {

// Starts Python on the first call; later calls from any thread return the same interpreter. The
// caller does not hold the interpreter's lock afterwards. Python runs until the process exits
// because NumPy cannot be initialised twice. ENGINE_NOT_INSTALLED without Python or NumPy.
Result<const PythonApi*> interpreter();

// Holds the interpreter's lock for a scope, on any thread; nests. Call interpreter() first.
class Locked {
 public:
  Locked();
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;
  ~Locked();

 private:
  int state_;
};

// A reference to a Python object. Create, move and destroy it under Locked.
class Object {
 public:
  Object() = default;
  static Object adopt(PyObject* object) { return Object(object); }
  static Object share(PyObject* object);
  Object(Object&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Object();
  PyObject* get() const noexcept { return object_; }
  PyObject* release() noexcept { return std::exchange(object_, nullptr); }
  explicit operator bool() const noexcept { return object_ != nullptr; }

 private:
  explicit Object(PyObject* object) : object_(object) {}
  PyObject* object_ = nullptr;
};

// Call everything below under Locked.

// Returns the dict of one of our own modules; the first call for this name runs `source`.
Result<PyObject*> module_of_ours(const char* name, const char* source);  // borrowed

// Calls `names[function]`. An exception becomes an error with `code`, its message and its
// traceback: the lines of the user's script, innermost last.
Result<Object> call(PyObject* names, const char* function, std::vector<Object> arguments,
                    Code code);

Object make_text(std::string_view text);

inline constexpr int kSimpleBuffer = 0;             // PyBUF_SIMPLE
inline constexpr int kDenseWithFormat = 0x4 | 0x8;  // PyBUF_FORMAT | PyBUF_ND

// The memory of an object, which stays in place while this exists. `flags` are PyBUF flags.
class HeldBuffer {
 public:
  HeldBuffer(PyObject* object, int flags);
  HeldBuffer(const HeldBuffer&) = delete;
  HeldBuffer& operator=(const HeldBuffer&) = delete;
  ~HeldBuffer();
  // False when the object has no such memory; Python's exception is set.
  explicit operator bool() const noexcept { return held_; }
  const Buffer& operator*() const noexcept { return buffer_; }
  const Buffer* operator->() const noexcept { return &buffer_; }

 private:
  Buffer buffer_{};
  bool held_;
};

// Clears the raised exception and returns it as an error.
Error take_exception(Code code);

}  // namespace weir::python
