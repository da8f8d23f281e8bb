// Decoder: an open decoder of any module.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/module/host.hpp"
#include "core/tensor/frame_spec.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

// The names of the options that a decoder declares, in order.
std::vector<std::string> option_names(const weir_decoder_type& type);

class Decoder {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;  // "option1", value
  static Result<std::unique_ptr<Decoder>> open(const weir_decoder_type& type,
                                               const Options& options);
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  // Passes the frame rate and the format of the input; call it before configure().
  void set_stream(const Fraction& rate, Format format) noexcept;
  // Passes the model whose outputs the stream has, or null; call it before configure().
  void set_model(const weir_stream_model* model) noexcept;
  // Passes the text fields of the input caps; call it before configure().
  void set_caps(const Options& fields);
  // The names of the classes of its results, after configure(); empty = not known.
  std::vector<std::string> labels() const;
  // The number of classes of the model, after configure(); 0 = not known.
  size_t classes() const noexcept;
  // Whether set_labels() has an effect: the decoder reads results.
  bool reads_results() const noexcept { return labels_ && labels_->set_labels; }
  // Passes the names of the classes of one source of results.
  void set_labels(const std::string& source, const std::vector<std::string>& names);
  // Passes the times of the next frame; call it before decode(). -1 = unknown.
  void set_times(int64_t running_time, int64_t unix_time) noexcept;
  // Whether tensors of flexible streams are passed with their headers.
  bool needs_headers() const noexcept;
  // Whether set_model() has an effect.
  bool uses_model() const noexcept { return model_ && model_->set_model; }
  // Passes the input tensors; the decoder sets its output caps through the sink.
  Status configure(const std::vector<weir_tensor_info>& inputs, weir_sink* sink);
  // True: the sink holds the output; false: the frame is dropped.
  Result<bool> decode(const weir_frame& frame, weir_sink* sink);
  // What the last decode() that succeeded warns of.
  const std::optional<Error>& warning() const noexcept { return warning_; }
  // The next frame does not continue the previous ones.
  void reset() noexcept;

 private:
  Decoder(const weir_decoder_type& type, weir_decoder* handle);
  const weir_decoder_type& type_;
  weir_decoder* handle_;
  std::optional<Error> warning_;
  const weir_decoder_stream* stream_;  // null: the decoder does not have the extension
  const weir_decoder_model* model_;    // likewise
  const weir_decoder_caps* caps_;      // likewise
  const weir_decoder_times* times_;    // likewise
  const weir_decoder_labels* labels_;  // likewise
};

}  // namespace weir::infer
