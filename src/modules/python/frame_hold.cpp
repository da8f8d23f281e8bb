// A capsule whose end is told.
#include "python3/frame_hold.hpp"

#include "module_host.hpp"
#include "weir/hold_frame.h"

namespace weir::engine {

constexpr char kName[] = "weir.frame";

struct FrameHold::State {
  FrameHold* hold;               // null when that is gone
  void (*release)(void* owner);  // null, or of memory that the host keeps
  void* owner;
};

FrameHold::FrameHold(const python::PythonApi& api) : state_(new State{this, nullptr, nullptr}) {
  owner_ = python::Object::adopt(api.PyCapsule_New(state_, kName, end));
  if (owner_) return;
  delete state_;
  state_ = nullptr;
}

FrameHold::~FrameHold() {
  let_go();
  if (state_) state_->hold = nullptr;
}

bool FrameHold::let_go() noexcept {
  { const python::Object last = std::move(owner_); }
  return is_gone();
}

bool FrameHold::keep(const weir_frame& frame) {
  const auto* holder =
      static_cast<const weir_frame_holder*>(module_host->extension(WEIR_HOLD_FRAME));
  return holder && holder->hold(&frame, &state_->release, &state_->owner) == WEIR_OK;
}

void FrameHold::end(python::PyObject* capsule) {
  const python::PythonApi& api = **python::interpreter();  // it runs: it calls us
  const std::unique_ptr<State> state(static_cast<State*>(api.PyCapsule_GetPointer(capsule, kName)));
  if (state->hold) state->hold->state_ = nullptr;
  if (state->release) state->release(state->owner);
}

}  // namespace weir::engine
