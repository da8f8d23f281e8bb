// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_library.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "environment.hpp"
#include "install_command.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

namespace fs = std::filesystem;

// The file that contains this function: the module.
fs::path module_path() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&module_path), &info) == 0 || !info.dli_fname) return {};
  std::error_code ignored;
  return fs::canonical(info.dli_fname, ignored);
}

Error not_installed(const std::string& name, const std::string& title, std::string offered,
                    std::string needed) {
  return Error{.code = Code::ENGINE_NOT_INSTALLED,
               .what = title + " is not installed",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = library_install_command(name)};
}

}  // namespace

std::vector<std::string> library_folders(const std::string& name) {
  const auto under = [&name](const fs::path& root) { return (root / name / "lib").string(); };
  const char* chosen = environment_variable("WEIR_ENGINES_DIR");
  if (chosen && *chosen) return {under(chosen)};
  return {under(module_path().parent_path().parent_path() / "engines")};
}

std::string library_install_command(const std::string& name) {
  return std::string(install_command("apt-get install --reinstall gstreamer1.0-weir-",
                                     "tools/setup --engine ")) +
         name;
}

Result<EngineLibrary> EngineLibrary::open(const std::string& name, const std::string& title,
                                          const std::vector<std::string>& files) {
  const auto folders = library_folders(name);
  for (const auto& folder : folders) {
    for (const auto& file : files) {
      const fs::path path = fs::path(folder) / file;
      std::error_code ignored;
      if (!fs::exists(path, ignored)) continue;
      if (void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL))
        return EngineLibrary(path.string(), handle);
      const char* reason = dlerror();
      Error error = not_installed(name, title, reason ? reason : path.string(),
                                  "a library that this machine can load");
      error.what = "the library of " + title + " exists but cannot be loaded";
      return error;
    }
  }
  return not_installed(name, title, "no " + files.front() + " in " + join(folders, ", "),
                       "that library; WEIR_ENGINES_DIR can name another folder with engines");
}

void* EngineLibrary::address(const char* name) const noexcept {
  return dlsym(handle_, name);
}

}  // namespace weir::engine
