// LuaRunner: frames through a script, with a state and globals of its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "lua/lua_model.hpp"

namespace weir::engine {

// Used by one thread at a time.
class LuaRunner {
 public:
  static Result<std::unique_ptr<LuaRunner>> create(const LuaModel& model,
                                                   std::span<const weir_option> options);

  // The shapes are those that the script's tables say: SPEC_MISMATCH for others.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Elements that the script does not write are 0. An output without data gets memory of the host.
  Status invoke(const weir_frame& in, weir_frame& out);
  Status reset_state() { return start(); }  // runs the script anew

 private:
  explicit LuaRunner(const LuaModel& model);
  Status start();
  Status take_inputs(const weir_frame& in);
  Status take_outputs(weir_frame& out);
  void let_go() noexcept;

  const LuaModel& model_;
  std::vector<TensorSlot> inputs_, outputs_;  // before the state that reads them
  std::unique_ptr<LuaState> state_;
};

}  // namespace weir::engine
