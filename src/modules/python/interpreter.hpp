// The one Python interpreter of a process, for modules that run scripts on streaming threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "python_api.hpp"

namespace weir::python {

// Starts Python at the first call; later calls, from any thread, give the same. The calling thread
// does not hold the interpreter's lock afterwards. It runs until the process ends, for NumPy cannot
// be started twice. ENGINE_NOT_INSTALLED without Python or NumPy.
Result<const PythonApi*> interpreter();

// Holds the interpreter's lock for a scope, on any thread; may be nested. After interpreter().
class Locked {
 public:
  Locked();
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;
  ~Locked();

 private:
  int state_;
};

// A reference to an object. Made, moved and destroyed under Locked.
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

// All below under Locked.

// Names of a module of our own: `source` is run at the first call for this name.
Result<PyObject*> module_of_ours(const char* name, const char* source);  // its dict, borrowed

// Calls `names[function]` with these arguments. An exception becomes an error with `code`, what it
// says, and where: the lines of the user's script, innermost last.
Result<Object> call(PyObject* names, const char* function, std::vector<Object> arguments,
                    Code code);

Object text_of(std::string_view text);

inline constexpr int kSimpleBuffer = 0;             // PyBUF_SIMPLE
inline constexpr int kDenseWithFormat = 0x4 | 0x8;  // PyBUF_FORMAT | PyBUF_ND

// The memory of an object, which stays where it is while this lives. `flags` say what is requested.
class HeldBuffer {
 public:
  HeldBuffer(PyObject* object, int flags);
  HeldBuffer(const HeldBuffer&) = delete;
  HeldBuffer& operator=(const HeldBuffer&) = delete;
  ~HeldBuffer();
  // False: the object has no such memory, and Python's exception is set.
  explicit operator bool() const noexcept { return held_; }
  const Buffer& operator*() const noexcept { return buffer_; }
  const Buffer* operator->() const noexcept { return &buffer_; }

 private:
  Buffer buffer_{};
  bool held_;
};

// The exception that was raised, cleared, as an error.
Error take_exception(Code code);

}  // namespace weir::python
