// Supports axis 0 only, in which frames are contiguous.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/batch.hpp"

#include <cstring>

#include "core/direct/inputs.hpp"
#include "core/direct/tensor_text.hpp"

namespace weir::direct {
namespace {

Error unsupported(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::BATCH_UNSUPPORTED,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "invoke the frames one by one"};
}

// Checks that axis 0 of this input can hold the frames.
Status check_axis(const weir_tensor_info& info, uint32_t frames, size_t index) {
  const uint32_t axis = info.batch_axis == WEIR_NO_BATCH_AXIS ? 0 : info.batch_axis;
  const bool free = info.rank <= WEIR_RANK_LIMIT && info.rank > 0 && axis == 0 &&
                    (info.shape[0] < 0 || info.shape[0] == frames);
  if (free) return ok();
  return unsupported(
      place_text("input", index, info) + " cannot hold " + std::to_string(frames) + " frames",
      to_string(info), "a free axis 0");
}

// The current shapes for one frame.
std::vector<weir_tensor_info> of_one_frame(std::vector<weir_tensor_info> infos) {
  for (auto& info : infos) info.shape[0] = 1;
  return infos;
}

Status check_same_shapes(const std::vector<weir_tensor_info>& infos, uint32_t frame,
                         const std::vector<weir_tensor_info>& first) {
  for (size_t i = 0; i < first.size(); ++i)
    if (const auto difference = shape_difference(infos[i], first[i]); !difference.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the frames of a batch have different shapes",
                   .offered = "frame " + std::to_string(frame) + ": " + to_string(infos[i]),
                   .needed = "as frame 0: " + to_string(first[i]),
                   .difference = difference};
  return ok();
}

// Copies input i of each frame, one after the other, into tensor i of `out`.
void copy_frames(std::span<const weir_tensor> inputs, uint32_t frames,
                 std::span<const weir_tensor> out) {
  for (size_t i = 0; i < out.size(); ++i) {
    auto* to = static_cast<char*>(out[i].data);
    for (uint32_t frame = 0; frame < frames; ++frame) {
      const weir_tensor& from = inputs[frame * out.size() + i];
      if (from.bytes > 0) std::memcpy(to + frame * from.bytes, from.data, from.bytes);
    }
  }
}

}  // namespace

Result<Batch> gather(std::span<const weir_tensor> inputs, uint32_t frames,
                     const weir_model_info& model, const std::vector<weir_tensor_info>& declared,
                     const std::vector<weir_tensor_info>& current) {
  if (model.flags & WEIR_MODEL_STATEFUL)
    return unsupported("the model keeps state between frames", std::to_string(frames) + " frames",
                       "one frame after the other");
  const uint64_t each = declared.size();
  if (frames == 0 || inputs.size() != each * frames)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the number of inputs is not a multiple of the model's inputs",
                 .offered = std::to_string(inputs.size()) + " tensors for " +
                            std::to_string(frames) + " frames",
                 .needed = std::to_string(each) + " for each of at least one frame",
                 .difference = "number of tensors"};
  for (size_t i = 0; i < each; ++i)
    if (auto status = check_axis(declared[i], frames, i); !status) return status.error();
  const auto one_declared = of_one_frame(declared), one_current = of_one_frame(current);
  const auto described = [&](uint64_t frame) {
    return described_inputs(inputs.subspan(frame * each, each), one_declared, one_current);
  };
  auto first = described(0);
  if (!first) return first.error();
  Batch out;
  out.infos = *first;
  for (auto& info : out.infos) info.shape[0] = frames;
  // Fails here for a number of frames that exceeds memory, before the other frames are read.
  out.memory = Results(out.infos);
  if (auto status = out.memory.allocate(1); !status) return status.error();
  for (uint32_t frame = 1; frame < frames; ++frame) {
    const auto infos = described(frame);
    if (!infos) return infos.error();
    if (auto status = check_same_shapes(*infos, frame, *first); !status) return status.error();
  }
  copy_frames(inputs, frames, out.memory.tensors());
  return out;
}

Status check_batched(const std::vector<weir_tensor>& outputs, uint32_t frames) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    const weir_tensor_info& info = outputs[i].info;
    if (info.rank == 0 || info.rank > WEIR_RANK_LIMIT || info.shape[0] != frames)
      return unsupported(place_text("output", i, info) + " does not hold the frames of the batch",
                         to_string(info), std::to_string(frames) + " in axis 0");
  }
  return ok();
}

}  // namespace weir::direct
