// What a mode knows of the model whose outputs it reads: from the stream, and from tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/heads/head.hpp"
#include "core/tensor/geometry.hpp"
#include "core/tensor/model_tensor.hpp"
#include "weir/abi.h"
#include "weir/source_map.hpp"

namespace weir::decoders {

// The model of the stream, as the extension weir.decoder-model/1 passes it.
class StreamModel {
 public:
  void set(const weir_stream_model* model) noexcept;
  // The file's name without folder and extension; "" = unknown.
  const std::string& name() const noexcept { return name_; }
  // Names of classes in the model's metadata: tflite.labels or character (a line each), names (as
  // Ultralytics writes them: {0: 'person', 1: 'bicycle'}); else those of its card.
  const std::vector<std::string>& labels() const noexcept { return labels_; }

  // Facts of a stream with these tensors. Without tensors (a flexible stream before its first
  // frame) those of the model; throws Failure (SPEC_MISMATCH) if the model is not known either.
  heads::ModelSignature facts(std::span<const weir_tensor_info> tensors, Size input,
                              size_t labels) const;
  heads::ModelSignature facts(std::span<const weir_tensor> tensors, Size input,
                              size_t labels) const;
  // The tensors with the model's quantisation where their element type is the model's. Valid until
  // the next call.
  std::span<const weir_tensor> with_quantisation(std::span<const weir_tensor> tensors);
  std::vector<weir_tensor_info> with_quantisation(std::span<const weir_tensor_info> infos) const;
  // The elements that turn integers of quantised outputs into real numbers; those that only convert
  // the type where the model is not known.
  std::string float32_elements() const;

 private:
  Size input_size() const noexcept;

  std::vector<ModelTensor> inputs_, outputs_;
  std::map<std::string, std::string> metadata_;
  std::vector<std::string> labels_;
  std::string name_;
  std::vector<weir_tensor> described_;
};

// Whether the outputs of `facts` have the types and shapes of these tensors.
bool has_shapes(const heads::ModelSignature& facts, std::span<const weir_tensor> tensors) noexcept;

// The facts of one picture of a batch: the outermost extent of each output, which all have in
// common, is 1. nullopt if there is no such extent above 1.
std::optional<heads::ModelSignature> without_batch(heads::ModelSignature facts);

// Whether the frame has the fields of source maps; frames of older hosts end before them.
bool has_map_fields(const weir_frame& frame) noexcept;

// The pictures in a frame: one, or one for each region of a batch (WEIR_MAPS_OF_REGIONS), whose
// tensors are slices of the frame's along their outermost dimension.
class FrameRegions {
 public:
  // Throws Failure (SPEC_MISMATCH) if a tensor has fewer slices than there are regions.
  explicit FrameRegions(const weir_frame& frame);
  uint32_t count() const noexcept { return count_; }
  bool are_regions() const noexcept { return are_regions_; }
  std::span<const weir_tensor> tensors(uint32_t region);  // valid until the next call
  std::optional<SourceMap> map(uint32_t region) const noexcept;
  // The row of the results that region `region` was cut out for; its own number if that is not
  // known.
  int32_t row(uint32_t region) const noexcept;

 private:
  const weir_frame& frame_;
  bool are_regions_ = false;
  uint32_t count_ = 1;
  std::vector<weir_tensor> slices_;
};

}  // namespace weir::decoders
