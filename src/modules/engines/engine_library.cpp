// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_library.hpp"

#include <dlfcn.h>
#include <link.h>

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

const char* chosen_folder() {
  const char* chosen = environment_variable("WEIR_ENGINES_DIR");
  return chosen && *chosen ? chosen : nullptr;
}

std::string fetch_command(const std::string& name) {
  return std::string(install_command("apt-get install --reinstall gstreamer1.0-weir-",
                                     "tools/setup --engine ")) +
         name;
}

// Debian names the package of a library after its soname: libfrob.so.1.2 is in libfrob1.2.
std::string package_command(std::string soname) {
  if (const auto at = soname.find(".so."); at != std::string::npos) soname.erase(at, 4);
  return "apt-get install --reinstall " + soname;
}

Error not_installed(const std::string& title, std::string offered, std::string fix) {
  return Error{.code = Code::ENGINE_NOT_INSTALLED,
               .what = title + " is not installed",
               .offered = std::move(offered),
               .needed = "that library; WEIR_ENGINES_DIR can name another folder with engines",
               .fix = std::move(fix)};
}

}  // namespace

std::vector<std::string> library_folders(const std::string& name) {
  const auto under = [&name](const fs::path& root) { return (root / name / "lib").string(); };
  if (const char* chosen = chosen_folder()) return {under(chosen)};
  return {under(module_path().parent_path().parent_path() / "engines")};
}

EngineLibrary::EngineLibrary(void* handle, std::string install_command, bool is_of_system)
    : handle_(handle), install_command_(std::move(install_command)), is_of_system_(is_of_system) {
  link_map* loaded = nullptr;
  if (dlinfo(handle_, RTLD_DI_LINKMAP, &loaded) == 0) path_ = loaded->l_name;
}

Result<EngineLibrary> EngineLibrary::load(const std::string& file, const std::string& title,
                                          const std::string& install_command) {
  const bool is_soname = file.find('/') == std::string::npos;
  if (void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL))
    return EngineLibrary(handle, install_command, is_soname);
  const char* reason = dlerror();
  Error error = not_installed(title, reason ? reason : file, install_command);
  // The loader's reason begins with the name of the file at fault: with the soname if no folder has
  // such a file, otherwise with a path, or with another library that this one needs.
  if (is_soname && error.offered.starts_with(file + ":")) return error;
  error.what = "the library of " + title + " exists but cannot be loaded";
  error.needed = "a library that this machine can load";
  return error;
}

Result<EngineLibrary> EngineLibrary::open(const std::string& name, const std::string& title,
                                          const std::vector<std::string>& files,
                                          const std::string& soname) {
  std::vector<std::string> folders;
  if (soname.empty() || chosen_folder()) folders = library_folders(name);
  for (const auto& folder : folders) {
    for (const auto& file : files) {
      const fs::path path = fs::path(folder) / file;
      std::error_code ignored;
      if (fs::exists(path, ignored)) return load(path.string(), title, fetch_command(name));
    }
  }
  if (!soname.empty()) return load(soname, title, package_command(soname));
  return not_installed(title, "no " + files.front() + " in " + join(folders, ", "),
                       fetch_command(name));
}

void* EngineLibrary::address(const char* name) const noexcept {
  return dlsym(handle_, name);
}

}  // namespace weir::engine
