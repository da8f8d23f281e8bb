// SPDX-License-Identifier: LGPL-2.1-or-later
#include "python_api.hpp"
#include "environment.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <string>

namespace weir::python {
namespace {

// The Pythons of Debian 12 and 13 first, because Debian's NumPy is built for them.
constexpr const char* kLibraries[] = {"libpython3.11.so.1.0", "libpython3.13.so.1.0",
                                      "libpython3.12.so.1.0", "libpython3.10.so.1.0",
                                      "libpython3.9.so.1.0"};

Error not_installed(std::string offered) {
  return {.code = Code::ENGINE_NOT_INSTALLED,
          .what = "Python is not installed as a library",
          .offered = std::move(offered),
          .needed = "libpython3, version 3.9 or later",
          .fix = "apt-get install libpython3-dev python3-numpy"};
}

// RTLD_GLOBAL, because extension modules resolve Python's functions in the process.
Result<void*> open_library() {
  const char* chosen = environment_variable("WEIR_PYTHON_LIBRARY");
  if (chosen && *chosen) {
    if (void* library = dlopen(chosen, RTLD_NOW | RTLD_GLOBAL)) return library;
    const char* reason = dlerror();
    return not_installed(reason ? reason : chosen);
  }
  for (const char* name : kLibraries)
    if (void* library = dlopen(name, RTLD_NOW | RTLD_GLOBAL)) return library;
  return not_installed(std::string("no ") + kLibraries[0]);
}

// Whether "3.11.2 (main, ...)" is 3.9 or later.
bool is_recent(const char* version) {
  char* rest = nullptr;
  const long major = std::strtol(version, &rest, 10);
  const long minor = *rest == '.' ? std::strtol(rest + 1, nullptr, 10) : 0;
  return major == 3 && minor >= 9;
}

// Cuts the version at the first blank, before the compiler and date.
std::string short_version(const char* version) {
  return std::string(version, std::strcspn(version, " "));
}

Error not_usable(void* library, const std::string& offered) {
  Dl_info place{};
  void* symbol = dlsym(library, "Py_GetVersion");
  const bool known = symbol && dladdr(symbol, &place) != 0 && place.dli_fname;
  Error error = not_installed((known ? place.dli_fname + std::string(": ") : "") + offered);
  error.what = "the Python on this machine cannot be used";
  return error;
}

}  // namespace

Result<PythonApi> find_python() {
  // A process that already contains Python must not load a second one.
  void* library = RTLD_DEFAULT;
  if (!dlsym(library, "Py_IsInitialized")) {
    auto opened = open_library();
    if (!opened) return opened.error();
    library = *opened;
  }
  const auto version = reinterpret_cast<const char* (*)()>(dlsym(library, "Py_GetVersion"));
  if (version && !is_recent(version()))
    return not_usable(library, "Python " + short_version(version()) + " is not supported");
  PythonApi api;
  const char* missing = nullptr;
// NOLINTBEGIN(bugprone-macro-parentheses): a member's name takes none
#define WEIR_PYTHON_FIND(result, name, arguments)                          \
  api.name = reinterpret_cast<result(*) arguments>(dlsym(library, #name)); \
  if (!api.name) missing = #name;
  // NOLINTEND(bugprone-macro-parentheses)
  WEIR_PYTHON_FUNCTIONS(WEIR_PYTHON_FIND)
#undef WEIR_PYTHON_FIND
  if (missing) return not_usable(library, std::string("a library without ") + missing);
  api.Py_SetProgramName =
      reinterpret_cast<void (*)(const wchar_t*)>(dlsym(library, "Py_SetProgramName"));
  return api;
}

}  // namespace weir::python
