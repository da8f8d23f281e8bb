// EngineLibrary: the shared library of an inference engine, found and opened at run time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

// Where the libraries of the engine `name` are looked for, in this order: the folder
// WEIR_ENGINES_DIR alone where that is set; else the folder that `make install` fills beside the
// module's own; else, for a module that lies in the build folder, the folder that tools/setup
// fills. Under each of them the file is NAME/lib/FILE.
std::vector<std::string> library_folders(const std::string& name);

class EngineLibrary {
 public:
  // `files`: names of the library, the first that is there is taken. It stays open until the
  // process ends, for engines keep threads and static objects. ENGINE_NOT_INSTALLED when it is not
  // there or cannot be loaded; `title` is the engine's name for people.
  static Result<EngineLibrary> open(const std::string& name, const std::string& title,
                                    const std::vector<std::string>& files);

  const std::string& path() const noexcept { return path_; }
  // Null when the library lacks the symbol.
  template <class Function>
  Function symbol(const char* name) const noexcept {
    return reinterpret_cast<Function>(address(name));
  }

 private:
  EngineLibrary(std::string path, void* handle) : path_(std::move(path)), handle_(handle) {}
  void* address(const char* name) const noexcept;

  std::string path_;
  void* handle_;  // of dlopen, never closed
};

}  // namespace weir::engine
