// python3 engine: the module's entry point; models are Python scripts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <dlfcn.h>

#include "python3/python_session.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct Python3Engine {
  static constexpr const char *kName = "python3", *kAliases = "python", *kExtensions = "py",
                              *kLibrary = "Python";
  static constexpr const char* kOptions = R"([
    {"name": "invoke-dynamic", "type": "boolean", "default": "false", "help": "sizes with each frame"},
    {"name": "custom", "type": "text", "default": "",
     "help": "all of custom=: arguments for the constructor of CustomFilter, separated by one blank"}])";
  using Model = PythonModel;
  using Session = PythonSession;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
    return text.find("class CustomFilter") == std::string_view::npos ? 0 : 90;
  }
  static Result<LibraryFacts> library() {
    const auto api = python::find_python();
    Dl_info info{};
    if (!api) return api.error();
    const bool placed = dladdr(reinterpret_cast<const void*>(api->Py_GetVersion), &info) != 0;
    return LibraryFacts{placed && info.dli_fname ? info.dli_fname : "", api->Py_GetVersion()};
  }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::Python3Engine)
