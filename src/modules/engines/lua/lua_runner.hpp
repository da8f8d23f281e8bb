// LuaRunner: runs a script on frames, with its own Lua state and globals.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "lua/lua_model.hpp"

namespace weir::engine {

// One thread at a time.
class LuaRunner {
 public:
  static Result<std::unique_ptr<LuaRunner>> create(const LuaModel& model,
                                                   std::span<const weir_option> options);

  // SPEC_MISMATCH for shapes other than those that the script's tables declare.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Elements that the script does not write are 0. The host allocates outputs without data.
  Result<bool> invoke(const weir_frame& in, weir_frame& out);
  Status reset_state() { return start(); }  // runs the script again

 private:
  explicit LuaRunner(const LuaModel& model);
  Status start();
  Status take_inputs(const weir_frame& in);
  Status take_outputs(weir_frame& out);
  void let_go() noexcept;

  const LuaModel& model_;
  std::vector<TensorSlot> inputs_, outputs_;  // declared before the state that reads them
  std::unique_ptr<LuaState> state_;
};

}  // namespace weir::engine
