// Writes the memories of frames in the layout of docs/compatibility/types-and-caps.md 1.6: one for
// each tensor; of more than 16, the 16th and all later ones are copied into one packed memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <span>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct TensorPiece {
  Ref<GstMemory> memory;  // with its header if the stream has headers
  TensorSpec spec;
};

// Appends the tensors that `layout` found in `buffer`, by reference if they can be shared. Copies
// are counted in `ledger`. Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Status append_pieces(GstBuffer* buffer, const FrameLayout& layout, Ledger* ledger,
                     std::vector<TensorPiece>* pieces);

// A memory with the 128-byte header followed by `bytes`.
// Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Result<TensorPiece> make_piece(const TensorHeader& header, std::span<const std::byte> bytes);

// The tensor preceded by the 128-byte header of a flexible stream: a copy, counted.
Result<TensorPiece> with_header(const TensorPiece& piece, Ledger* ledger);

// Appends the pieces to `buffer`, at most 256. Memories that are not packed are moved out of
// `pieces`; copies are counted in `copied`.
Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, uint64_t* copied);
Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, Ledger* ledger);

// Writes the n-th tensor into `bytes` (with a header if the stream has headers).
using FillTensor = std::function<Status(size_t n, std::span<std::byte> bytes)>;
// Allocates and appends memories for these tensors. Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Status append_filled(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     GstBuffer* buffer, const FillTensor& fill);

// A part of a buffer that need not hold tensors.
struct BufferPart {
  Ref<GstMemory> memory;             // must no longer be mapped for writing
  std::span<const std::byte> bytes;  // copied when there is no memory
};
// Allocates the memory into which bytes are copied.
using AllocateBytes = std::function<Result<Ref<GstMemory>>(size_t bytes)>;

// Appends the parts in order, one memory each. Of more than 16 parts, the 16th and all later ones
// share one memory without a packed header: GStreamer would otherwise merge, and therefore map,
// memories automatically.
// Errors: MAPPING_FAILED, those of `allocate`. Precondition: `out` has no memory.
Status append_parts(std::span<const BufferPart> parts, GstBuffer* out,
                    const AllocateBytes& allocate);

// Makes a buffer of the `chosen` tensors (indices into layout.tensors()) with the metadata of `in`.
Result<Ref<GstBuffer>> pick_tensors(GstBuffer* in, const FrameLayout& layout,
                                    std::span<const size_t> chosen, uint64_t* copied);
// The same as a frame of `pool`: for static tensors that need headers.
Result<Ref<GstBuffer>> copy_tensors(GstBuffer* in, const FrameLayout& layout,
                                    std::span<const size_t> chosen, FramePool* pool,
                                    uint64_t* copied);

// Makes an empty buffer with the timestamps, flags and metas of `in`, for its memories
// (sharing_buffer()).
Ref<GstBuffer> buffer_like(GstBuffer* in);

// Makes the GAP event in the place of a frame without results; null if the frame has no time.
Ref<GstEvent> gap_like(GstBuffer* frame);

// Makes an empty buffer for memories of `owners` or parts of them. Owners from a pool are held
// until the buffer has dropped its memories: a pool discards a returned buffer whose memory is
// still in use and would allocate for each frame. GstParentBufferMeta releases the owner too early
// for that; also unlike it, this reference is not copied with metadata.
Ref<GstBuffer> sharing_buffer(std::span<GstBuffer* const> owners);

}  // namespace weir::gst
