// FrameDecoder: an open decoder from any source: a Weir module, an NNStreamer sub-plugin or a
// registered function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/filter/described_model.hpp"
#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "elements/tensor_decoder/decoder_options.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/element/ref.hpp"
#include "gstcpp/element/result_events.hpp"
#include "weir/result.hpp"

namespace weir {

class FrameDecoder {
 public:
  virtual ~FrameDecoder() = default;
  // The model whose outputs the stream has, or null; takes effect with configure(). uses_model():
  // whether that matters.
  virtual void set_model(const std::shared_ptr<const DescribedModel>&) {}
  virtual bool uses_model() const noexcept { return false; }
  // Returns the output caps for the input's tensors; adds the stream's frame rate if the decoder
  // leaves it open.
  virtual Result<gst::Ref<GstCaps>> configure(const FrameSpec& input) = 0;
  // `input` is the spec of the last configure(). Appends memory to `out`, which has the metadata of
  // `in` and no memory; `reader` holds the tensors of `in`. False: the frame is dropped.
  // LIMIT_EXCEEDED when the output needs more memory than `limit` allows.
  virtual Result<bool> decode(const FrameSpec& input, GstBuffer* in, const gst::FrameLayout& reader,
                              GstBuffer* out, const BufferLimit& limit, Ledger* ledger) = 0;
  // What the last decode() warns of.
  virtual std::optional<Error> warning() const { return std::nullopt; }
  // The input caps, before configure(): fields beyond the spec, for decoders that use them.
  virtual void set_caps(const GstCaps*) {}
  // The names of the classes of its results, after configure(); empty = not known.
  virtual std::vector<std::string> labels() const { return {}; }
  // Whether it reads results, whose rows may be none, instead of the outputs of a network.
  virtual bool reads_results() const noexcept { return false; }
  // The number of classes of the model, after configure(); 0 = not known.
  virtual size_t classes() const noexcept { return 0; }
  // The names of the classes of one source of the stream's results, from the next frame on.
  virtual void set_labels(const gst::LabelsOfSource&) {}
  // The times of the next frame in nanoseconds, before decode(): running time, and when it was
  // captured, since 1970 UTC. -1 = unknown.
  virtual void set_times(int64_t /*running_time*/, int64_t /*unix_time*/) noexcept {}
  // The following frames do not continue the previous ones.
  virtual void reset() noexcept {}
};

struct OpenDecoder {
  std::shared_ptr<FrameDecoder> decoder;
  std::shared_ptr<FrameDecoder> probe;  // answers caps queries on any thread; may be the same
  std::vector<Error> warnings{};        // to be posted
};

// Opens the decoder of `mode`: a Weir module, else an NNStreamer sub-plugin; custom-code: the
// registered function named by option1. DECODER_UNKNOWN, CALLBACK_UNKNOWN, listing the names.
// Options that it does not use are warnings.
Result<OpenDecoder> open_decoder(const std::string& mode, DecoderOptions options);
// Valid names for mode=, sorted; opens none.
std::vector<std::string> decoder_names();

}  // namespace weir
