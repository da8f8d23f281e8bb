// Handles: numbers for objects, never reused, so that a destroyed handle is distinguished from a
// valid one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "weir/result.hpp"

namespace weir::application {

class Object {
 public:
  Object() = default;
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  virtual ~Object() = default;
  static constexpr const char* kKind = "object";
  virtual const char* kind() const noexcept = 0;  // "tensors info"
};

// Process-wide. Thread-safe; objects are destroyed outside its lock.
class Handles {
 public:
  static Handles& all();

  void* add(std::shared_ptr<Object> object);
  // Finds the object of a handle. OPTION_VALUE: null, another kind, destroyed, or never issued.
  // `what` names the argument.
  template <class T>
  Result<std::shared_ptr<T>> find(void* handle, const char* what) {
    return as<T>(handle, what, lookup(handle, false));
  }
  // Does the same, and removes the handle.
  template <class T>
  Result<std::shared_ptr<T>> take(void* handle, const char* what) {
    auto found = find<T>(handle, what);
    if (!found) return found;
    return as<T>(handle, what, lookup(handle, true));
  }

 private:
  std::shared_ptr<Object> lookup(void* handle, bool away);
  Error no_object(void* handle, const char* what, const char* kind, const Object* other);
  template <class T>
  Result<std::shared_ptr<T>> as(void* handle, const char* what, std::shared_ptr<Object> object) {
    if (auto typed = std::dynamic_pointer_cast<T>(object)) return typed;
    return no_object(handle, what, T::kKind, object.get());
  }

  std::mutex mutex_;  // guards the rest
  std::unordered_map<std::uintptr_t, std::shared_ptr<Object>> objects_;
  std::uintptr_t next_ = 1;
};

}  // namespace weir::application
