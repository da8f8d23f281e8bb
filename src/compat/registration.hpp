// What the registering functions of sub-plugins share.
#pragma once
#include <cstdarg>
#include <initializer_list>

#include "compat/guard.hpp"
#include "core/subplugin/loader.hpp"
#include "core/subplugin/table.hpp"

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
// From the table or a file; null, with a line in the log, without.
const void* find_descriptor(const char* function, subplugin::Kind kind, const char* name) noexcept;
// Pairs of key and text, ended with NULL.
void describe(const char* function, subplugin::Kind kind, const char* name, const char* key,
              va_list texts) noexcept;

// Functions of a program by name: 0, -EINVAL, -ENOMEM.
int register_function(const char* function, subplugin::Functions& functions, const char* name,
                      subplugin::AnyFunction callback, void* data) noexcept;
int unregister_function(const char* function, subplugin::Functions& functions,
                        const char* name) noexcept;

}  // namespace weir::compat
