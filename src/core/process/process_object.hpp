// Singletons of a process that may contain several copies of this code: the library libweir and
// GStreamer's plug-in each contain core. The plug-in takes its objects from the library.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>

namespace weir::process {

// Creates an object that lives until the process ends.
using Make = void* (*)();
// Returns the object of that name, created by the first call. Thread-safe.
using Lookup = void* (*)(const char* name, size_t size, Make make);

// The objects of this copy. `size` is part of the name, and so is Weir's version: two versions in
// one process share nothing.
void* local_object(const char* name, size_t size, Make make);

// Sets the source of this copy's objects; the default is local_object. Call it before the first
// object().
void take_objects_from(Lookup lookup) noexcept;
Lookup lookup() noexcept;

// The process's `T` of that name. It is never destroyed, since threads may outlive static objects.
template <class T>
T& object(const char* name) {
  return *static_cast<T*>(
      lookup()(name, sizeof(T), []() -> void* { return std::make_unique<T>().release(); }));
}

}  // namespace weir::process
