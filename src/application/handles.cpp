// SPDX-License-Identifier: LGPL-2.1-or-later
#include "handles.hpp"

namespace weir::application {
namespace {

constexpr std::uintptr_t kStep = 2;

std::uintptr_t to_number(void* handle) noexcept {
  return reinterpret_cast<std::uintptr_t>(handle);
}

}  // namespace

Handles& Handles::all() {
  static auto* handles = new Handles;  // never freed: callbacks may run until the process ends
  return *handles;
}

void* Handles::add(std::shared_ptr<Object> object) {
  std::lock_guard lock(mutex_);
  objects_.emplace(next_, std::move(object));
  // NOLINTNEXTLINE(performance-no-int-to-ptr): a handle of the C API, never dereferenced
  void* handle = reinterpret_cast<void*>(next_);
  next_ += kStep;
  return handle;
}

std::shared_ptr<Object> Handles::lookup(void* handle, bool away) {
  std::lock_guard lock(mutex_);
  const auto found = objects_.find(to_number(handle));
  if (found == objects_.end()) return nullptr;
  auto object = found->second;
  if (away) objects_.erase(found);
  return object;
}

Error Handles::no_object(void* handle, const char* what, const char* kind, const Object* other) {
  Error error{.code = Code::OPTION_VALUE, .needed = std::string("a handle of type ") + kind};
  bool given = false;
  {
    std::lock_guard lock(mutex_);
    given = to_number(handle) % kStep == 1 && to_number(handle) < next_;
  }
  error.what = what;
  if (other) {
    error.what += " is a handle of a different type";
    error.offered = std::string("a handle of type ") + other->kind();
  } else if (!handle) {
    error.what += " is a null pointer";
  } else if (given) {
    error.what += " is a handle that was destroyed or released";
  } else {
    error.what += " is not a handle";
  }
  return error;
}

}  // namespace weir::application
