// EngineLibrary: the shared library of an inference engine, loaded at run time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

// Where to search the fetched libraries of the engine `name`: in WEIR_ENGINES_DIR when that is set,
// otherwise in the folder `engines` beside the module's own. `make install` and packages fill it;
// in the build folder it is a link to what tools/setup fetched. The file is NAME/lib/FILE in it.
std::vector<std::string> library_folders(const std::string& name);

class EngineLibrary {
 public:
  // Loads the first existing library of `files`. It stays loaded until the process exits, because
  // engines keep threads and static objects. ENGINE_NOT_INSTALLED when it is missing or cannot be
  // loaded; `title` is the engine's name in error texts.
  // `soname` is set when the module was built for a library of the system: then that library is
  // loaded, unless WEIR_ENGINES_DIR has one of `files`.
  static Result<EngineLibrary> open(const std::string& name, const std::string& title,
                                    const std::vector<std::string>& files,
                                    const std::string& soname = {});

  const std::string& path() const noexcept { return path_; }
  // Whether it was loaded by its soname.
  bool is_of_system() const noexcept { return is_of_system_; }
  // The command for an error about this library.
  const std::string& install_command() const noexcept { return install_command_; }
  // Returns null when the library lacks the symbol.
  template <class Function>
  Function symbol(const char* name) const noexcept {
    return reinterpret_cast<Function>(address(name));
  }

 private:
  EngineLibrary(void* handle, std::string install_command, bool is_of_system);
  // `file` is a path or a soname.
  static Result<EngineLibrary> load(const std::string& file, const std::string& title,
                                    const std::string& install_command);
  void* address(const char* name) const noexcept;

  void* handle_;  // from dlopen, never closed
  std::string path_, install_command_;
  bool is_of_system_;
};

}  // namespace weir::engine
