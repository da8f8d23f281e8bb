// Finding Python: in the process, or its library.
#include "python_api.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <string>

namespace weir::python {
namespace {

// Debian 12's first: its NumPy is built for it.
constexpr const char* kLibraries[] = {"libpython3.11.so.1.0", "libpython3.13.so.1.0",
                                      "libpython3.12.so.1.0", "libpython3.10.so.1.0",
                                      "libpython3.9.so.1.0"};

Error not_installed(std::string offered) {
  return {Code::ENGINE_NOT_INSTALLED,
          "Python is not installed as a library",
          std::move(offered),
          "libpython3, version 3.9 or later",
          "",
          "apt-get install libpython3.11 python3-numpy"};
}

// Extension modules find Python's functions among the process's own: hence RTLD_GLOBAL.
Result<void*> open_library() {
  const char* chosen = std::getenv("WEIR_PYTHON_LIBRARY");
  if (chosen && *chosen) {
    if (void* library = dlopen(chosen, RTLD_NOW | RTLD_GLOBAL)) return library;
    const char* reason = dlerror();
    return not_installed(reason ? reason : chosen);
  }
  for (const char* name : kLibraries)
    if (void* library = dlopen(name, RTLD_NOW | RTLD_GLOBAL)) return library;
  return not_installed(std::string("no ") + kLibraries[0]);
}

}  // namespace

Result<PythonApi> find_python() {
  // A program that is Python itself (or has embedded it) must not get a second one.
  void* library = RTLD_DEFAULT;
  if (!dlsym(library, "Py_IsInitialized")) {
    auto opened = open_library();
    if (!opened) return opened.error();
    library = *opened;
  }
  PythonApi api;
  const char* missing = nullptr;
#define WEIR_PYTHON_FIND(result, name, arguments)                          \
  api.name = reinterpret_cast<result(*) arguments>(dlsym(library, #name)); \
  if (!api.name) missing = #name;
  WEIR_PYTHON_FUNCTIONS(WEIR_PYTHON_FIND)
#undef WEIR_PYTHON_FIND
  if (missing) return not_installed(std::string("a library without ") + missing);
  api.Py_SetProgramName =
      reinterpret_cast<void (*)(const wchar_t*)>(dlsym(library, "Py_SetProgramName"));
  return api;
}

}  // namespace weir::python
