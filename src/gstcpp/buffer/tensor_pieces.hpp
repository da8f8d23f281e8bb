// TensorPieces: the memory of each tensor of a frame, shared from its buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <span>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct TensorPiece {
  Ref<GstMemory> memory;  // with its header if the stream has headers
  TensorSpec spec;
};

// Appends the tensors of `buffer`, whose caps give `spec`. A static stream with one memory per
// tensor is not mapped. Copies (merged memories) are counted in `ledger`.
// Errors: FRAME_SIZE, HEADER_INVALID, MAPPING_FAILED, OUT_OF_MEMORY.
Status append_pieces(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                     std::vector<TensorPiece>* pieces);

// A memory with the 128-byte header followed by `bytes`.
// Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Result<TensorPiece> make_piece(const TensorHeader& header, std::span<const std::byte> bytes);

// The tensor preceded by the 128-byte header of a flexible stream: a copy, counted.
Result<TensorPiece> with_header(const TensorPiece& piece, Ledger* ledger);

// Appends the pieces to `buffer` as docs/compatibility/types-and-caps.md 1.6 requires: the 17th and
// later ones are copied into one packed memory, counted. At most 256. Memories that are not packed
// are moved out of `pieces`.
Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, Ledger* ledger);

// Allocates and appends memories for these tensors in the same layout. `fill` writes the n-th
// tensor into `bytes` (with a header if the stream has headers).
// Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Status append_filled(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     GstBuffer* buffer,
                     const std::function<Status(size_t n, std::span<std::byte> bytes)>& fill);

}  // namespace weir::gst
