// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_runner.hpp"

#include <algorithm>
#include <cstring>

#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

void fill(TensorSlot* slot, const weir_tensor& tensor, bool shared) {
  slot->data = tensor.data;
  slot->bytes = tensor.bytes;
  slot->shared = shared ? 1 : 0;
}

std::vector<TensorSlot> slots_for(const std::vector<weir_tensor_info>& infos) {
  std::vector<TensorSlot> slots(infos.size());
  for (size_t i = 0; i < infos.size(); ++i) {
    slots[i].type = infos[i].type;
    const uint64_t elements = *tensor_bytes(infos[i]) / element_bytes(infos[i].type);
    slots[i].elements = static_cast<double>(elements);
  }
  return slots;
}

}  // namespace

LuaRunner::LuaRunner(const LuaModel& model)
    : model_(model), inputs_(slots_for(model.inputs())), outputs_(slots_for(model.outputs())) {}

Result<std::unique_ptr<LuaRunner>> LuaRunner::create(const LuaModel& model,
                                                     std::span<const weir_option>) {
  std::unique_ptr<LuaRunner> out(new LuaRunner(model));
  if (auto status = out->start(); !status) return status.error();
  return out;
}

Status LuaRunner::start() {
  auto state = model_.state();
  if (!state) return state.error();
  if (auto status = (*state)->bind(&inputs_, &outputs_); !status) return status;
  state_ = *std::move(state);
  return ok();
}

Status LuaRunner::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  if (auto status = check_infos(model_.inputs(), in, "input"); !status) return status;
  if (auto status = check_count(model_.outputs(), out.size(), "output"); !status) return status;
  std::copy(model_.outputs().begin(), model_.outputs().end(), out.begin());
  return ok();
}

Status LuaRunner::take_inputs(const weir_frame& in) {
  const auto tensors = get_tensors(in);
  if (auto status = check_inputs(model_.inputs(), tensors); !status) return status;
  for (size_t i = 0; i < tensors.size(); ++i) fill(&inputs_[i], tensors[i], true);
  return ok();
}

Status LuaRunner::take_outputs(weir_frame& out) {
  const auto tensors = get_tensors(out);
  if (auto status = check_count(model_.outputs(), tensors.size(), "output"); !status) return status;
  for (size_t i = 0; i < tensors.size(); ++i) {
    const auto& info = model_.outputs()[i];
    if (!tensors[i].data) weir::allocate(&tensors[i], info, *tensor_bytes(info));
    tensors[i].info = info;
    if (auto status = check_memory(tensors[i], i, "output"); !status) return status;
    std::memset(tensors[i].data, 0, tensors[i].bytes);
    fill(&outputs_[i], tensors[i], false);
  }
  return ok();
}

void LuaRunner::let_go() noexcept {
  for (auto* slots : {&inputs_, &outputs_})
    for (auto& slot : *slots) {
      slot.data = nullptr;
      slot.shared = 0;
    }
}

Result<bool> LuaRunner::invoke(const weir_frame& in, weir_frame& out) {
  Status status = take_inputs(in);
  if (status) status = take_outputs(out);
  auto kept = status ? state_->invoke() : Result<bool>(status.error());
  let_go();
  return kept;
}

}  // namespace weir::engine
