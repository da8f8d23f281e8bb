// BufferOwner: holds the memory of a filter's input beyond its invoke, for engines that ask.
#pragma once
#include <gst/gst.h>

#include <span>

#include "core/infer/held_frame.hpp"

namespace weir {

class BufferOwner final : public infer::FrameOwner {
 public:
  // Both borrowed.
  BufferOwner(GstBuffer* buffer, std::span<const weir_tensor> inputs)
      : buffer_(buffer), inputs_(inputs) {}
  // Null where an input is a copy that the filter made, or memory that another mapping moves.
  std::shared_ptr<const void> hold() override;

 private:
  GstBuffer* buffer_;
  std::span<const weir_tensor> inputs_;
};

}  // namespace weir
