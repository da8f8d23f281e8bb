// Looks for rows and prototypes among the outputs, and into the metadata.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/yolo_facts.hpp"

#include <utility>

#include "core/text/text.hpp"

namespace weir::heads {
namespace {

// Prototypes have the input's aspect, usually a quarter of its width and height. Without an input
// size they are square.
std::optional<PrototypeFacts> prototypes_of(const Shape& shape, size_t output,
                                            detection::PictureSize input) {
  if (shape.min_rank() != 3) return std::nullopt;
  const auto is_grid = [&](uint32_t width, uint32_t height, uint32_t count) {
    if (input.width == 0) return width == height && count < width;
    return uint64_t{width} * input.height == uint64_t{height} * input.width;
  };
  if (is_grid(shape[0], shape[1], shape[2]))
    return PrototypeFacts{output, shape[0], shape[1], shape[2], false};
  if (is_grid(shape[1], shape[2], shape[0]))
    return PrototypeFacts{output, shape[1], shape[2], shape[0], true};
  return std::nullopt;
}

template <class FindLayout>
std::optional<YoloOutputs> find_outputs(const ModelFacts& model, bool has_prototypes,
                                        FindLayout find_layout) {
  if (model.outputs.size() != (has_prototypes ? 2 : 1)) return std::nullopt;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const auto layout = find_layout(model.outputs[i].shape, model.input);
    if (!layout) continue;
    YoloOutputs out{.output = i, .layout = *layout};
    if (!has_prototypes) return out;
    const auto input = model.input.width > 0 ? model.input : layout->input;
    out.prototypes = prototypes_of(model.outputs[1 - i].shape, 1 - i, input);
    if (out.prototypes) return out;
  }
  return std::nullopt;
}

}  // namespace

std::optional<YoloOutputs> find_yolo_outputs(const ModelFacts& model, size_t anchors,
                                             bool has_prototypes) {
  return find_outputs(
      model, has_prototypes,
      [&](const Shape& shape, detection::PictureSize input) -> std::optional<DenseLayout> {
        auto layout = find_dense_layout(shape, input);
        if (layout && layout->anchors == anchors) return layout;
        return std::nullopt;
      });
}

std::optional<YoloOutputs> any_yolo_outputs(const ModelFacts& model, bool has_prototypes) {
  return find_outputs(model, has_prototypes, any_dense_layout);
}

std::optional<bool> is_for_task(const ModelFacts& model, std::string_view task) {
  const auto stated = metadata(model, "task");
  return stated.empty() ? std::nullopt : std::optional(equal_ignoring_case(stated, task));
}

std::optional<PointShape> point_shape(const ModelFacts& model) {
  std::string_view text = strip(metadata(model, "kpt_shape"));
  if (!text.starts_with('[') || !text.ends_with(']')) return std::nullopt;
  const auto parts = split(text.substr(1, text.size() - 2), ",");
  if (parts.size() != 2) return std::nullopt;
  const auto points = parse_unsigned(strip(parts[0])), length = parse_unsigned(strip(parts[1]));
  const bool is_good =
      points && length && *points > 0 && *points < 1024 && (*length == 2 || *length == 3);
  return is_good ? std::optional(PointShape{*points, *length}) : std::nullopt;
}

}  // namespace weir::heads
