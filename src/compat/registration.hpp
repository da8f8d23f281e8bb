// Helpers of the functions that register sub-plugins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cerrno>
#include <cstdarg>
#include <initializer_list>
#include <new>

#include "compat/guard.hpp"
#include "core/subplugin/loader.hpp"
#include "core/subplugin/table.hpp"
#include "weir/error.h"
#include "weir/module.hpp"

namespace weir::compat {

// A required part of a descriptor.
struct Needed {
  const char* name;
  bool there;
};

// Adds a descriptor to the process-wide table and returns 1. Returns 0 when a part is missing or
// the name is not available; the reason is logged and becomes part of the error of the load.
int register_descriptor(const char* function, subplugin::Kind kind, const char* name,
                        const void* descriptor, std::initializer_list<Needed> parts) noexcept;
void unregister_descriptor(const char* function, subplugin::Kind kind, const char* name) noexcept;
// Looks in the table, in files, then in `builtin`; null, with a log line, if not found.
template <class Descriptor>
const Descriptor* find_descriptor(const char* function, subplugin::Kind kind, const char* name,
                                  Result<const Descriptor*> (*builtin)(const char*)) noexcept {
  if (!given(function, {name})) return nullptr;
  return or_else<const Descriptor*>(function, nullptr, [&]() -> const Descriptor* {
    const auto found = subplugin::open(kind, name);
    if (found && *found) return static_cast<const Descriptor*>(*found);
    const auto own = found ? builtin(name) : Result<const Descriptor*>(found.error());
    if (own) return *own;
    warn(function, own.error());
    return nullptr;
  });
}
// Stores NULL-terminated pairs of key and text.
void describe(const char* function, subplugin::Kind kind, const char* name, const char* key,
              va_list texts) noexcept;

// Returns the result of a libweir function: 0, -EINVAL or -ENOMEM. Logs and frees its error.
int to_errno(const char* function, int code, weir_error* error = nullptr);
// Does the same for the result of `body`; logs its exceptions.
template <class Body>
int guarded_errno(const char* function, Body&& body) noexcept {
  try {
    return body();
  } catch (const Failure& failure) {
    warn(function, failure.error());
  } catch (const std::bad_alloc&) {
    return -ENOMEM;
  } catch (const std::exception& e) {
    warn(function, e.what());
  }
  return -EINVAL;
}

// Checks `name`, and logs an error when `add`, a function of libweir, reports that it is in use.
// `what`: "function".
template <class Add>
int register_name(const char* function, const char* what, const char* name, Add&& add) noexcept {
  return guarded_errno(function, [&] {
    if (auto status = subplugin::check_name(name); !status) {
      warn(function, status.error());
      return -EINVAL;
    }
    const int result = to_errno(function, add());
    if (result == -EINVAL)
      warn(function, std::string("another ") + what + " already has the name " + name);
    return result;
  });
}

// Registers a program's function by name: 0, -EINVAL, -ENOMEM.
int register_function(const char* function, subplugin::Functions& functions, const char* name,
                      subplugin::AnyFunction callback, void* data) noexcept;
int unregister_function(const char* function, subplugin::Functions& functions,
                        const char* name) noexcept;

}  // namespace weir::compat
