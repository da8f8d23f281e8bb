// LuaState: a Lua state that runs one script, with the script's tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lua/lua_api.hpp"
#include "lua/lua_options.hpp"
#include "weir/abi.h"

namespace weir::engine {

// The elements of one tensor of the current frame. prelude.lua declares the same struct up to
// `elements`; it reads `type` and `elements` once, in bind(), and `data` and `shared` on each
// access.
struct TensorSlot {
  void* data = nullptr;
  int32_t shared = 0;   // nonzero: others read this memory; the first write copies it to `own`
  uint32_t type = 0;    // weir_type
  double elements = 0;  // bounds of each access
  size_t bytes = 0;
  std::vector<std::byte> own;
};

struct ScriptTensors {
  std::vector<weir_tensor_info> inputs, outputs;
};

// One thread at a time. Every failure of a script becomes an error, except an endless loop.
class LuaState {
 public:
  // OUT_OF_MEMORY or INTERNAL when the state cannot be created.
  static Result<std::unique_ptr<LuaState>> create(const LuaApi& api, const LuaOptions& options);
  ~LuaState();
  LuaState(const LuaState&) = delete;
  LuaState& operator=(const LuaState&) = delete;

  // Makes require() search `folder`, "" for none, and not the working directory, unless LUA_PATH or
  // LUA_CPATH set what is searched.
  Status search_in(const std::string& folder);
  // Runs the source text; `name` appears in messages. MODEL_INVALID with file, line and traceback,
  // and for byte code.
  Status run(std::string_view text, const std::string& name);
  // Reads the tensors that the script's tables declare. MODEL_INVALID names the invalid field.
  Result<ScriptTensors> describe();
  // Fills one slot per tensor of describe() with its type and number of elements. The slots must
  // outlive the state.
  Status bind(std::vector<TensorSlot>* inputs, std::vector<TensorSlot>* outputs);
  // Calls nnstreamer_invoke(); false if that returned false. INVOKE_FAILED with file, line and
  // traceback.
  Result<bool> invoke();

  uint64_t bytes() const;  // currently allocated by Lua

 private:
  // Counts the state's allocations and fails those beyond the limit.
  struct Budget {
    LuaAllocator allocate;
    void* data;
    ptrdiff_t used, limit;
  };
  struct Binding {
    int function;
    std::vector<TensorSlot>*inputs, *outputs;
  };

  LuaState(const LuaApi& api, const LuaOptions& options) : api_(api), options_(options) {}
  static void* within_budget(void* budget, void* block, size_t old_bytes, size_t bytes);
  static int prepare(lua_State* state);
  // Reads the result of prelude.lua's describe() at stack index 1.
  Result<ScriptTensors> read_flat_list();
  static int bind_slots(lua_State* state);
  // Makes an error from the value on top of the stack and pops it.
  Error failure(Code code, std::string what, int status);

  const LuaApi& api_;
  const LuaOptions options_;
  lua_State* state_ = nullptr;
  Budget budget_{};
  int traceback_ = 0, describe_ = 0, bind_ = 0, invoke_ = 0;  // references in the registry
};

}  // namespace weir::engine
