// What the registering functions of sub-plugins share.
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

// A part of a descriptor that must be there.
struct Needed {
  const char* name;
  bool there;
};

// Adds a descriptor to the process's table: 1; 0, with the reason in the log and in the error of
// who loads its file, when a part of it is missing or its name cannot be had.
int register_descriptor(const char* function, subplugin::Kind kind, const char* name,
                        const void* descriptor, std::initializer_list<Needed> parts) noexcept;
void unregister_descriptor(const char* function, subplugin::Kind kind, const char* name) noexcept;
// From the table or a file, else what `builtin` has of this name; null, with a line in the log,
// without.
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
// Pairs of key and text, ended with NULL.
void describe(const char* function, subplugin::Kind kind, const char* name, const char* key,
              va_list texts) noexcept;

// 0, -EINVAL, -ENOMEM: what a function of libweir returned. Its error goes to the log and is freed.
int answer_of(const char* function, int code, weir_error* error = nullptr);
// The same of what `body` returns; what it throws goes to the log.
template <class Body>
int answered(const char* function, Body&& body) noexcept {
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

// Checks `name` and says where `add`, a function of libweir, finds it taken. `what`: "function".
template <class Add>
int register_name(const char* function, const char* what, const char* name, Add&& add) noexcept {
  return answered(function, [&] {
    if (auto status = subplugin::check_name(name); !status) {
      warn(function, status.error());
      return -EINVAL;
    }
    const int answer = answer_of(function, add());
    if (answer == -EINVAL)
      warn(function, std::string("another ") + what + " has the name " + name + " already");
    return answer;
  });
}

// Functions of a program by name: 0, -EINVAL, -ENOMEM.
int register_function(const char* function, subplugin::Functions& functions, const char* name,
                      subplugin::AnyFunction callback, void* data) noexcept;
int unregister_function(const char* function, subplugin::Functions& functions,
                        const char* name) noexcept;

}  // namespace weir::compat
