// Applies the arithmetic of cascade.hpp to tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "filters.hpp"

#include <algorithm>

#include "weir/source_map.hpp"

namespace mtcnn {
namespace {

using weir::Box;

[[noreturn]] void refuse(const char* what, std::string offered, std::string needed) {
  throw weir::Failure({.code = weir::Code::SPEC_MISMATCH,
                       .what = what,
                       .offered = std::move(offered),
                       .needed = std::move(needed)});
}

// Finds the tensor with this number of channels, because network files differ in their order.
const weir_tensor& with_channels(std::span<const weir_tensor> tensors, int64_t channels,
                                 size_t axis_of_four) {
  for (const auto& tensor : tensors) {
    const size_t axis = tensor.info.rank == 4 ? axis_of_four : 1;
    if (axis < tensor.info.rank && tensor.info.shape[axis] == channels) return tensor;
  }
  refuse("a network's output is missing",
         tensors.empty() ? "no tensor" : weir::describe(tensors[0].info),
         "a tensor of " + std::to_string(channels) + " channels");
}

// Finds the channel axis, 1 or 3: the maps have 2 and 4 channels and the same size.
size_t channel_axis(std::span<const weir_tensor> layer) {
  for (const auto& map : layer)
    if (map.info.rank != 4)
      refuse("P-Net gives no maps", weir::describe(map.info), "four dimensions");
  return layer[0].info.shape[1] != layer[1].info.shape[1] ? 1 : 3;
}

Steps find_steps(const weir_tensor_info& info, bool planes, bool turned) {
  size_t step[4] = {0, 0, 0, 1};
  for (size_t axis = 3; axis > 0; --axis)
    step[axis - 1] = step[axis] * static_cast<size_t>(info.shape[axis]);
  const size_t first = step[planes ? 2 : 1], second = step[planes ? 3 : 2];
  return {turned ? first : second, turned ? second : first, step[planes ? 1 : 3]};
}

ProposalMap make_map(std::span<const weir_tensor> layer, bool turned) {
  const size_t axis = channel_axis(layer);
  const auto& face = with_channels(layer, 2, axis);
  const auto& box = with_channels(layer, 4, axis);
  const size_t first = axis == 1 ? 2 : 1;
  for (size_t i = first; i < first + 2; ++i)
    if (face.info.shape[i] != box.info.shape[i])
      refuse("P-Net's maps are of two sizes", weir::describe(box.info), weir::describe(face.info));
  const auto a = static_cast<uint32_t>(face.info.shape[first]);
  const auto b = static_cast<uint32_t>(face.info.shape[first + 1]);
  return {turned ? Size{a, b} : Size{b, a}, weir::elements<const float>(face),
          weir::elements<const float>(box), find_steps(face.info, axis == 1, turned),
          find_steps(box.info, axis == 1, turned)};
}

void give_regions(const std::vector<Box>& boxes, weir_tensor* out) {
  const size_t count = std::max<size_t>(boxes.size(), 1);
  const auto info = weir::tensor_info("regions", WEIR_FLOAT32, {static_cast<int64_t>(count), 4});
  weir::allocate(out, info, count * 4 * sizeof(float));
  const auto rows = weir::elements<float>(*out);
  if (boxes.empty())
    std::ranges::copy(std::initializer_list<float>{0.f, 0.f, 1.f, 1.f}, rows.begin());
  for (size_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    std::ranges::copy(std::initializer_list<float>{box.x1, box.y1, box.width(), box.height()},
                      rows.begin() + static_cast<ptrdiff_t>(4 * i));
  }
}

// The source regions of each row of a frame.
std::vector<Box> read_regions(const weir_frame& frame, uint32_t side, size_t count) {
  std::vector<Box> out;
  for (uint32_t i = 0; i < count; ++i) {
    const auto map = weir::source_map(frame, i);
    if (!map) refuse("regions come without a source map", "", "frames of tensor_preprocess");
    const auto end = static_cast<double>(side);
    const weir::Point from = map->to_source({0, 0}), to = map->to_source({end, end});
    out.push_back({static_cast<float>(from.x), static_cast<float>(from.y), static_cast<float>(to.x),
                   static_cast<float>(to.y)});
  }
  return out;
}

std::span<const float> rows(const weir_frame& frame, int64_t channels, size_t count) {
  const auto values =
      weir::elements<const float>(with_channels({frame.tensors, frame.n_tensors}, channels, 3));
  const size_t needed = count * static_cast<size_t>(channels);
  if (values.size() < needed)
    refuse("a network gives too few rows", std::to_string(values.size()) + " numbers",
           std::to_string(count) + " rows of " + std::to_string(channels));
  return values.first(needed);
}

// The number of regions in the frame; a batch of fixed size has unused rows after them.
size_t regions_in(const weir_frame& frame) {
  return frame.n_maps;
}

weir_tensor_info open(const char* name, std::initializer_list<int64_t> shape) {
  return weir::tensor_info(name, WEIR_FLOAT32, shape);
}

}  // namespace

weir::RegisteredFilter proposals(const Setup& setup, StageTimes* times) {
  weir::FilterDescription description;
  description.outputs = {open("regions", {-1, 4})};
  description.dynamic = true;
  description.inputs.assign(2 * setup.layers.size(), open("map", {-1, -1, -1, -1}));
  return {"mtcnn-proposals", description, [setup, times](const weir_frame& in, weir_frame& out) {
            const std::span<const weir_tensor> maps(in.tensors, in.n_tensors);
            std::vector<Candidate> all;
            for (size_t i = 0; i < setup.layers.size(); ++i)
              for (const auto& one : propose(make_map(maps.subspan(2 * i, 2), setup.turned),
                                             setup.layers[i], setup.picture))
                all.push_back(one);
            give_regions(join(std::move(all), setup.picture), &out.tensors[0]);
            times->reached(Stage::Proposed, in.pts);
          }};
}

weir::RegisteredFilter refinement(const Setup& setup, StageTimes* times) {
  return {"mtcnn-refinement",
          {.inputs = {open("a", {-1, -1}), open("b", {-1, -1})},
           .outputs = {open("regions", {-1, 4})},
           .dynamic = true},
          [picture = setup.picture, times](const weir_frame& in, weir_frame& out) {
            const size_t count = regions_in(in);
            give_regions(refine(read_regions(in, kRefineSide, count), rows(in, 2, count),
                                rows(in, 4, count), picture),
                         &out.tensors[0]);
            times->reached(Stage::Refined, in.pts);
          }};
}

weir::RegisteredFilter landmarks(StageTimes* times) {
  using Row = weir::DetectionRow<float>;
  constexpr size_t kLength = Row::length(kPoints);
  return {"mtcnn-landmarks",
          {.inputs = {open("a", {-1, -1}), open("b", {-1, -1}), open("c", {-1, -1})},
           .outputs = {open("faces", {-1, kLength})},
           .dynamic = true},
          [times](const weir_frame& in, weir_frame& out) {
            const size_t count = regions_in(in);
            const auto found = faces(read_regions(in, kLandmarkSide, count), rows(in, 2, count),
                                     rows(in, 4, count), rows(in, 10, count));
            const size_t n = std::max<size_t>(found.size(), 1);
            weir::allocate(&out.tensors[0], open("faces", {static_cast<int64_t>(n), kLength}),
                           n * kLength * sizeof(float));
            const auto all = weir::elements<float>(out.tensors[0]);
            std::ranges::fill(all, 0.f);
            for (size_t i = 0; i < found.size(); ++i) {
              const Row row(all.subspan(i * kLength, kLength));
              row.set_box(found[i].box);
              row.score() = found[i].score;
              for (size_t p = 0; p < kPoints; ++p) {
                row.x(p) = found[i].points[2 * p];
                row.y(p) = found[i].points[2 * p + 1];
              }
            }
            times->reached(Stage::Marked, in.pts);
          }};
}

}  // namespace mtcnn
