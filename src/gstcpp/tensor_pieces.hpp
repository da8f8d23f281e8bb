// TensorPieces: the memory of each tensor of a frame, shared out of its buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <span>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

struct TensorPiece {
  Ref<GstMemory> memory;  // with its header, where the stream has headers
  TensorSpec spec;
};

// Appends the tensors of `buffer`, whose caps say `spec`. Nothing is mapped in a static stream that
// lies as it should. What must be copied (memories that are merged) is counted in `ledger`.
// Errors: FRAME_SIZE, HEADER_INVALID, MAP_FAILED, OUT_OF_MEMORY.
Status append_pieces(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                     std::vector<TensorPiece>* pieces);

// The tensor with the 128-byte header of a flexible stream in front: a copy, counted.
Result<TensorPiece> with_header(const TensorPiece& piece, Ledger* ledger);

// Appends them to `buffer` as the specification, 1.6, says: from the 17th on they are copied into
// one packed memory, counted. At most 256. Memories that are not packed are moved out.
Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, Ledger* ledger);

// Memories of these tensors, laid out in the same way, are allocated and appended; `fill` writes
// the n-th into `bytes` of its size (with a header, if the stream has headers).
// Errors: MAP_FAILED, OUT_OF_MEMORY.
Status append_filled(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     GstBuffer* buffer,
                     const std::function<Status(size_t n, std::span<std::byte> bytes)>& fill);

}  // namespace weir::gst
