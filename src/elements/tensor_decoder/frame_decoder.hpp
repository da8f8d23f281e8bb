// FrameDecoder: what an opened decoder does with frames, whoever brings it: a module of Weir, a
// sub-plugin for NNStreamer, a function of the program.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/frame_reader.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir {

class FrameDecoder {
 public:
  virtual ~FrameDecoder() = default;
  // The input's tensors -> the caps of the output, with the stream's rate where the decoder leaves
  // that to the host.
  virtual Result<gst::Ref<GstCaps>> configure(const FrameSpec& input) = 0;
  // `input` as configured last for the stream. Appends to `out`, which has the metadata of `in` and
  // no memory; `reader` holds the tensors of `in`. False: the frame is dropped. LIMIT_EXCEEDED when
  // it asks for more memory than `limit` allows.
  virtual Result<bool> decode(const FrameSpec& input, GstBuffer* in, const gst::FrameReader& reader,
                              GstBuffer* out, const BufferLimit& limit, Ledger* ledger) = 0;
  // The frames that follow do not continue those before.
  virtual void reset() noexcept {}
};

using DecoderOptions = std::array<std::optional<std::string>, 9>;  // option1 to option9

struct OpenedDecoder {
  std::shared_ptr<FrameDecoder> decoder;
  std::shared_ptr<FrameDecoder> probe;  // answers caps queries, from any thread; may be the same
  std::vector<Error> warnings{};        // to be told
};

// By mode: a module of Weir, then a sub-plugin for NNStreamer; custom-code: the function of the
// program that option1 names. DECODER_UNKNOWN, CALLBACK_UNKNOWN with the names that there are.
Result<OpenedDecoder> open_decoder(const std::string& mode, const DecoderOptions& options);
// Names for mode=, sorted; nothing is opened.
std::vector<std::string> decoder_names();

}  // namespace weir
