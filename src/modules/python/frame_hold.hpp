// FrameHold: tells whether anything in Python still reads the memory of a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "interpreter.hpp"
#include "weir/abi.h"

namespace weir::python {

// Under Locked. The arrays of a frame have an object of Python for their owner, and so has every
// view of them and every buffer that is taken from them; it goes with the last one.
class FrameHold {
 public:
  explicit FrameHold(const PythonApi& api);
  FrameHold(const FrameHold&) = delete;
  FrameHold& operator=(const FrameHold&) = delete;
  ~FrameHold();

  // Null with Python's exception set when memory ran out.
  const Object& owner() const noexcept { return owner_; }
  // Gives our own reference up: true when it was the last.
  bool let_go() noexcept;
  bool is_gone() const noexcept { return state_ == nullptr; }
  // After let_go() has given false, within invoke: has the host keep the frame's memory until the
  // last array is gone. False where it cannot.
  bool keep(const weir_frame& frame);

 private:
  struct State;
  static void end(PyObject* capsule);

  State* state_;  // of the capsule; null when that is gone
  Object owner_;
};

}  // namespace weir::python
