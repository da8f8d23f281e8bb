// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frame_hold.hpp"

#include "weir/abi.h"
#include "weir/module.hpp"

namespace weir::python {

constexpr char kName[] = "weir.frame";

struct FrameHold::State {
  FrameHold* hold;               // null when the FrameHold is gone
  void (*release)(void* owner);  // releases memory that the host keeps; or null
  void* owner;
};

FrameHold::FrameHold(const PythonApi& api) : state_(new State{this, nullptr, nullptr}) {
  owner_ = Object::adopt(api.PyCapsule_New(state_, kName, end));
  if (owner_) return;
  delete state_;
  state_ = nullptr;
}

FrameHold::~FrameHold() {
  let_go();
  if (state_) state_->hold = nullptr;
}

bool FrameHold::let_go() noexcept {
  { const Object last = std::move(owner_); }
  return is_gone();
}

bool FrameHold::keep(const weir_frame& frame) {
  const auto* holder =
      static_cast<const weir_frame_holder*>(module_host->extension(WEIR_HOLD_FRAME));
  return holder && holder->hold(&frame, &state_->release, &state_->owner) == WEIR_OK;
}

void FrameHold::end(PyObject* capsule) {
  const PythonApi& api = **interpreter();  // initialised, since Python calls this
  const std::unique_ptr<State> state(static_cast<State*>(api.PyCapsule_GetPointer(capsule, kName)));
  if (state->hold) state->hold->state_ = nullptr;
  if (state->release) state->release(state->owner);
}

}  // namespace weir::python
