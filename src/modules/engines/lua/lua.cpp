// Lua engine: the module's entry point.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_model.hpp"
#include "lua/lua_runner.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct LuaEngine {
  static constexpr const char *kName = "lua", *kAliases = "", *kExtensions = "lua",
                              *kLibrary = "Lua";
  static constexpr uint64_t kFlags =
      WEIR_ENGINE_MODEL_IS_NO_FILE;  // model= may be the script itself
  static constexpr const char* kOptions = R"([
    {"name": "Libraries", "type": "text", "default": "",
     "help": "additional libraries for the script, separated by +: jit, ffi; in a sandbox also io, os, package, debug"},
    {"name": "Sandbox", "type": "boolean", "default": "false", "setting": "lua/sandbox",
     "help": "no io, os, package, debug, dofile, loadfile for the script; default: [lua] sandbox of weir.ini"},
    {"name": "MemoryLimit", "type": "integer", "default": "256",
     "help": "MiB that Lua may allocate for one worker"}])";
  using Model = LuaModel;
  using Session = LuaRunner;

  static int probe(const std::string& path, std::span<const unsigned char> head) {
    return lua_score(path, head);
  }
  static Result<LibraryFacts> library() {
    const auto api = LuaApi::instance();
    if (!api) return api.error();
    return LibraryFacts{(*api)->path, (*api)->version};
  }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::LuaEngine)
