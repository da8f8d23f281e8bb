// Objects of which a process has one, though it may hold several copies of this code: the library
// libweir and GStreamer's plug-in each contain core. The plug-in takes its objects from the
// SPDX-License-Identifier: LGPL-2.1-or-later
// library.
#pragma once
#include <cstddef>

namespace weir::process {

// Makes an object that lives until the process ends.
using Make = void* (*)();
// The object of that name; made by the first call. Thread-safe.
using Lookup = void* (*)(const char* name, size_t size, Make make);

// The objects of this copy. `size` is part of the name, and so is Weir's version: two versions in
// one process share nothing.
void* local_object(const char* name, size_t size, Make make);

// Where the objects of this copy come from: local_object until it is called. Before object() is
// called for the first time.
void take_objects_from(Lookup lookup) noexcept;
Lookup lookup() noexcept;

// The process's `T` of that name. It is never destroyed: threads may outlive static objects.
template <class T>
T& object(const char* name) {
  return *static_cast<T*>(lookup()(name, sizeof(T), []() -> void* { return new T; }));
}

}  // namespace weir::process
