// EngineLibrary: the shared library of an inference engine, loaded at run time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

// Where to search the libraries of the engine `name`: only in WEIR_ENGINES_DIR when that is set;
// otherwise in the folder next to the module's own that `make install` fills; then, for a module in
// the build folder, in the folder that tools/setup fills. In each folder the file is NAME/lib/FILE.
std::vector<std::string> library_folders(const std::string& name);

class EngineLibrary {
 public:
  // Loads the first existing library of `files`. It stays loaded until the process exits, because
  // engines keep threads and static objects. ENGINE_NOT_INSTALLED when it is missing or cannot be
  // loaded; `title` is the engine's name in error texts.
  static Result<EngineLibrary> open(const std::string& name, const std::string& title,
                                    const std::vector<std::string>& files);

  const std::string& path() const noexcept { return path_; }
  // Returns null when the library lacks the symbol.
  template <class Function>
  Function symbol(const char* name) const noexcept {
    return reinterpret_cast<Function>(address(name));
  }

 private:
  EngineLibrary(std::string path, void* handle) : path_(std::move(path)), handle_(handle) {}
  void* address(const char* name) const noexcept;

  std::string path_;
  void* handle_;  // from dlopen, never closed
};

}  // namespace weir::engine
