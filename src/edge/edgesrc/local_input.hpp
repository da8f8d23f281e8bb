// LocalInput: buffers in the memory of an edgesink of another process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "edge/edgesrc/buffer_input.hpp"
#include "transport/local/subscriber.hpp"

namespace weir {

class LocalInput : public BufferInput {
 public:
  // Connects. `interruption` is borrowed. Errors: those of local::Subscriber::connect().
  static Result<std::unique_ptr<BufferInput>> connect(const std::string& path, int interruption);
  Result<InputEvent> receive() override;

 private:
  LocalInput(local::Subscriber subscriber, int interruption)
      : subscriber_(std::move(subscriber)), interruption_(interruption) {}

  local::Subscriber subscriber_;
  const int interruption_;
};

}  // namespace weir
