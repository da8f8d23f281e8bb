// LuaApi: the LuaJIT functions that the engine calls, loaded at run time. Building needs no Lua
// header: these are the signatures of the Lua 5.1 manual and LuaJIT's extensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>

#include "weir/result.hpp"

struct lua_State;

namespace weir::engine {

using LuaFunction = int (*)(lua_State*);
using LuaAllocator = void* (*)(void* data, void* block, size_t old_bytes, size_t bytes);

#define WEIR_LUA_FUNCTIONS(X)                                                           \
  X(lua_State*, luaL_newstate, ())                                                      \
  X(void, lua_close, (lua_State*))                                                      \
  X(LuaAllocator, lua_getallocf, (lua_State*, void**))                                  \
  X(void, lua_setallocf, (lua_State*, LuaAllocator, void*))                             \
  X(int, luaL_loadbufferx, (lua_State*, const char*, size_t, const char*, const char*)) \
  X(int, lua_pcall, (lua_State*, int, int, int))                                        \
  X(int, lua_cpcall, (lua_State*, LuaFunction, void*))                                  \
  X(void, lua_call, (lua_State*, int, int))                                             \
  X(int, lua_error, (lua_State*))                                                       \
  X(int, lua_gettop, (lua_State*))                                                      \
  X(void, lua_settop, (lua_State*, int))                                                \
  X(void, lua_pushvalue, (lua_State*, int))                                             \
  X(void, lua_pushcclosure, (lua_State*, LuaFunction, int))                             \
  X(void, lua_pushlightuserdata, (lua_State*, void*))                                   \
  X(void, lua_pushstring, (lua_State*, const char*))                                    \
  X(void, lua_pushnumber, (lua_State*, double))                                         \
  X(void, lua_pushnil, (lua_State*))                                                    \
  X(void, lua_pushboolean, (lua_State*, int))                                           \
  X(int, lua_toboolean, (lua_State*, int))                                              \
  X(void, lua_getfield, (lua_State*, int, const char*))                                 \
  X(void, lua_setfield, (lua_State*, int, const char*))                                 \
  X(void, lua_rawgeti, (lua_State*, int, int))                                          \
  X(int, luaL_ref, (lua_State*, int))                                                   \
  X(int, lua_type, (lua_State*, int))                                                   \
  X(const char*, lua_typename, (lua_State*, int))                                       \
  X(const char*, lua_tolstring, (lua_State*, int, size_t*))                             \
  X(double, lua_tonumber, (lua_State*, int))                                            \
  X(void*, lua_touserdata, (lua_State*, int))                                           \
  X(int, lua_gc, (lua_State*, int, int))                                                \
  X(void, luaL_traceback, (lua_State*, lua_State*, const char*, int))                   \
  X(int, luaopen_base, (lua_State*))                                                    \
  X(int, luaopen_table, (lua_State*))                                                   \
  X(int, luaopen_string, (lua_State*))                                                  \
  X(int, luaopen_math, (lua_State*))                                                    \
  X(int, luaopen_bit, (lua_State*))                                                     \
  X(int, luaopen_jit, (lua_State*))                                                     \
  X(int, luaopen_ffi, (lua_State*))                                                     \
  X(int, luaopen_io, (lua_State*))                                                      \
  X(int, luaopen_os, (lua_State*))                                                      \
  X(int, luaopen_debug, (lua_State*))                                                   \
  X(int, luaopen_package, (lua_State*))

struct LuaApi {
// NOLINTNEXTLINE(bugprone-macro-parentheses): a type takes none
#define WEIR_LUA_POINTER(result, name, arguments) result(*name) arguments = nullptr;
  WEIR_LUA_FUNCTIONS(WEIR_LUA_POINTER)
#undef WEIR_LUA_POINTER
  std::string path;     // path of the library
  std::string version;  // as the library reports it: "LuaJIT 2.1.0-beta3"

  // Loads the library once per process; after a failure the next call tries again.
  // ENGINE_NOT_INSTALLED when the library is missing or is not LuaJIT 2.1 with FFI.
  static Result<const LuaApi*> instance();
};

// Constants of lua.h, the same in every Lua 5.1.
inline constexpr int kLuaRegistry = -10000, kLuaGlobals = -10002, kLuaAllResults = -1;
inline constexpr int kLuaOutOfMemory = 4;  // result of lua_pcall
inline constexpr int kLuaNil = 0, kLuaBoolean = 1, kLuaString = 4, kLuaTable = 5;
inline constexpr int kLuaCountKibibytes = 3, kLuaCountRest = 4,
                     kLuaSetStep = 7;  // commands of lua_gc

}  // namespace weir::engine
