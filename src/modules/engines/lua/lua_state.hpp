// LuaState: one script in a state of its own, with its tensors.
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

// Where the elements of one tensor of the current frame are. prelude.lua declares the same struct
// down to `elements`. It reads `type` and `elements` once, in bind(), and `data` and `shared` on
// each access.
struct TensorSlot {
  void* data = nullptr;
  int32_t shared = 0;   // nonzero: others read this memory, a script that writes gets `own` first
  uint32_t type = 0;    // weir_type
  double elements = 0;  // the bounds of each access
  size_t bytes = 0;
  std::vector<std::byte> own;
};

struct ScriptTensors {
  std::vector<weir_tensor_info> inputs, outputs;
};

// Used by one thread at a time. Whatever a script does in Lua ends in an error, but a loop without
// an end.
class LuaState {
 public:
  // OUT_OF_MEMORY or INTERNAL when no state can be made.
  static Result<std::unique_ptr<LuaState>> create(const LuaApi& api, const LuaOptions& options);
  ~LuaState();
  LuaState(const LuaState&) = delete;
  LuaState& operator=(const LuaState&) = delete;

  // Runs the script's text; `name` is for messages. MODEL_INVALID with the script's file, line and
  // traceback; byte code is refused.
  Status run(std::string_view text, const std::string& name);
  // What its tables say. MODEL_INVALID with the name of the field.
  Result<ScriptTensors> describe();
  // One slot for each tensor of describe(), with its type and number of elements. They outlive the
  // state.
  Status bind(std::vector<TensorSlot>* inputs, std::vector<TensorSlot>* outputs);
  // Calls nnstreamer_invoke(). INVOKE_FAILED with file, line and traceback.
  Status invoke();

  uint64_t bytes() const;  // that Lua has allocated

 private:
  // Counts what the state allocates, and refuses what would be too much.
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
  // Of prelude.lua's describe(), which lies at place 1 of the stack.
  Result<ScriptTensors> read_flat_list();
  static int bind_slots(lua_State* state);
  // Of what lies on top of the stack, which it takes away.
  Error failure(Code code, std::string what, int status);

  const LuaApi& api_;
  const LuaOptions options_;
  lua_State* state_ = nullptr;
  Budget budget_{};
  int traceback_ = 0, describe_ = 0, bind_ = 0, invoke_ = 0;  // of the registry
};

}  // namespace weir::engine
