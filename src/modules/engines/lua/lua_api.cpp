// Opening LuaJIT.
#include "lua/lua_api.hpp"

#include <dlfcn.h>

#include <memory>
#include <mutex>

namespace weir::engine {
namespace {

constexpr char kLibrary[] = "libluajit-5.1.so.2";

Error not_installed(std::string what, std::string offered) {
  return {Code::ENGINE_NOT_INSTALLED,
          std::move(what),
          std::move(offered),
          std::string(kLibrary) + ", LuaJIT 2.1 with FFI",
          "",
          "apt-get install libluajit-5.1-2"};
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
