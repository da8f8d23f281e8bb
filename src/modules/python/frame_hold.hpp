// FrameHold: detects whether anything in Python still reads the memory of a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "interpreter.hpp"
#include "weir/abi.h"

namespace weir::python {

// Call under Locked. A Python object owns the arrays of a frame, every view of them and every
// buffer taken from them; it is destroyed with the last one.
class FrameHold {
 public:
  explicit FrameHold(const PythonApi& api);
  FrameHold(const FrameHold&) = delete;
  FrameHold& operator=(const FrameHold&) = delete;
  ~FrameHold();

  // Null, with Python's exception set, when memory runs out.
  const Object& owner() const noexcept { return owner_; }
  // Releases our own reference; true when it was the last one.
  bool let_go() noexcept;
  bool is_gone() const noexcept { return state_ == nullptr; }
  // Call within invoke, after let_go() returned false: asks the host to keep the frame's memory
  // until the last array is gone. False when the host cannot.
  bool keep(const weir_frame& frame);

 private:
  struct State;
  static void end(PyObject* capsule);

  State* state_;  // the capsule's state; null when the capsule is gone
  Object owner_;
};

}  // namespace weir::python
