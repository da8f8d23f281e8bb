// LuaModel: a script that has run once, with the tensors that its tables declare.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "lua/lua_state.hpp"

namespace weir::engine {

class LuaModel {
 public:
  // Opens the file that model= names; without such a file, model= is the source itself.
  static Result<std::unique_ptr<LuaModel>> open(const weir_open& request);
  LuaModel(const LuaModel&) = delete;
  LuaModel& operator=(const LuaModel&) = delete;

  void describe(weir_model_info* info) const;
  const std::vector<weir_tensor_info>& inputs() const noexcept { return tensors_.inputs; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return tensors_.outputs; }
  // Returns a new state in which the script has run. Thread-safe. MODEL_INVALID when this run
  // declares other tensors than the first.
  Result<std::unique_ptr<LuaState>> state() const;

 private:
  explicit LuaModel(const LuaApi& api) : api_(api) {}
  Result<std::unique_ptr<LuaState>> new_state(ScriptTensors* tensors) const;

  const LuaApi& api_;
  LuaOptions options_;
  std::string text_, name_, folder_;
  ScriptTensors tensors_;
  uint64_t state_bytes_ = 0;
  mutable std::mutex mutex_;                 // guards first_
  mutable std::unique_ptr<LuaState> first_;  // state of the first run, until it is taken
  std::string metadata_;
};

// Returns 0 to 100: the confidence that the file is a script for this engine.
int lua_score(const std::string& path, std::span<const unsigned char> head);

}  // namespace weir::engine
