// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_api.hpp"

#include <dlfcn.h>

#include <memory>
#include <mutex>

namespace weir::engine {
namespace {

constexpr char kLibrary[] = "libluajit-5.1.so.2";

Error not_installed(std::string what, std::string offered) {
  return {.code = Code::ENGINE_NOT_INSTALLED,
          .what = std::move(what),
          .offered = std::move(offered),
          .needed = std::string(kLibrary) + ", LuaJIT 2.1 with FFI",
          .fix = "apt-get install libluajit-5.1-2"};
}

// The version that the library reports; jit.version_num is 20100 for 2.1.0.
struct Version {
  std::string text;
  double number = 0;
};

Version find_version(const LuaApi& api) {
  lua_State* state = api.luaL_newstate();
  if (!state) return {};
  Version out;
  api.lua_pushcclosure(state, api.luaopen_jit, 0);
  api.lua_pushstring(state, "jit");
  if (api.lua_pcall(state, 1, 0, 0) == 0) api.lua_getfield(state, kLuaGlobals, "jit");
  if (api.lua_gettop(state) == 1 && api.lua_type(state, 1) == kLuaTable) {
    api.lua_getfield(state, 1, "version_num");
    out.number = api.lua_tonumber(state, -1);
    api.lua_getfield(state, 1, "version");
    const char* text = api.lua_tolstring(state, -1, nullptr);
    out.text = text ? text : "";
  }
  api.lua_close(state);
  return out;
}

Result<std::unique_ptr<const LuaApi>> load() {
  void* handle = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    const char* reason = dlerror();
    return not_installed("LuaJIT is not installed", reason ? reason : kLibrary);
  }
  auto api = std::make_unique<LuaApi>();
  std::string missing;
  const auto want = [&](auto* function, const char* name) {
    *function = reinterpret_cast<std::remove_pointer_t<decltype(function)>>(dlsym(handle, name));
    if (!*function && missing.empty()) missing = name;
  };
#define WEIR_LUA_LOOK_UP(result, name, arguments) want(&api->name, #name);
  WEIR_LUA_FUNCTIONS(WEIR_LUA_LOOK_UP)
#undef WEIR_LUA_LOOK_UP
  if (!missing.empty()) {
    dlclose(handle);
    return not_installed("the LuaJIT on this machine cannot be used", "no symbol " + missing);
  }
  Dl_info place{};
  if (dladdr(reinterpret_cast<void*>(api->luaL_newstate), &place) && place.dli_fname)
    api->path = place.dli_fname;
  constexpr double kMin = 20100;
  const Version version = find_version(*api);
  if (version.number < kMin) {
    Error error =
        not_installed("the LuaJIT on this machine cannot be used",
                      (api->path.empty() ? kLibrary : api->path) + ": " +
                          (version.text.empty() ? "no version" : version.text) + " is too old");
    dlclose(handle);
    return error;
  }
  api->version = version.text;
  return std::unique_ptr<const LuaApi>(std::move(api));
}

}  // namespace

Result<const LuaApi*> LuaApi::instance() {
  static std::mutex mutex;  // guards `api`
  static std::unique_ptr<const LuaApi> api;
  const std::lock_guard lock(mutex);
  if (api) return api.get();
  auto loaded = load();
  if (!loaded) return loaded.error();
  api = *std::move(loaded);
  return api.get();
}

}  // namespace weir::engine
