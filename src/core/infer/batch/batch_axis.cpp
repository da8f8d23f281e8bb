// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_axis.hpp"

#include <algorithm>

#include "core/tensor/element_type.hpp"
#include "weir/join.hpp"

namespace weir::infer {
namespace {

using Infos = std::vector<weir_tensor_info>;

// Innermost first as in caps, '?' for an open extent.
std::string to_string(const weir_tensor_info& info) {
  std::string out(info.type < WEIR_TYPE_END ? to_string(static_cast<ElementType>(info.type))
                                            : "any type");
  if (info.rank == WEIR_RANK_UNKNOWN) return out + " of any dimension";
  out += ' ';
  if (info.rank == 0) return out + "1";
  for (uint32_t i = info.rank; i-- > 0;)
    out += (info.shape[i] < 0 ? "?" : std::to_string(info.shape[i])) + (i ? ":" : "");
  return out;
}

std::string to_string(const Infos& inputs, const Infos& outputs) {
  const auto text = [](const weir_tensor_info& info) { return to_string(info); };
  return "in " + join(inputs, ", ", text) + "; out " + join(outputs, ", ", text);
}

std::string name_of_tensor(const char* role, size_t index, const weir_tensor_info& info) {
  std::string out = role + std::string(" ") + std::to_string(index);
  if (info.name && *info.name) out += " (" + std::string(info.name) + ")";
  return out;
}

Error unsupported(std::string what, const Infos& inputs, const Infos& outputs, size_t batch_size,
                  std::string difference, std::string fix) {
  return Error{.code = Code::BATCH_UNSUPPORTED,
               .what = std::move(what),
               .offered = to_string(inputs, outputs),
               .needed = "a first axis that is open, or of length " + std::to_string(batch_size) +
                         ", in every input and output",
               .difference = std::move(difference),
               .fix = std::move(fix)};
}

constexpr const char* kExport = "export the model with a dynamic first axis, or set batch-size=1";

// The extent of a tensor on the batch axis, if any.
struct Axis {
  uint32_t axis = 0;
  int64_t length = 0;
  std::string missing;  // the reason if there is none
};
Axis find_axis(const weir_tensor_info& info, bool input) {
  const bool is_declared = info.batch_axis != WEIR_NO_BATCH_AXIS;
  if (info.rank == WEIR_RANK_UNKNOWN && !input) return {0, -1, ""};
  if (info.rank == WEIR_RANK_UNKNOWN) return {0, 0, "its number of dimensions is unknown"};
  if (info.rank == 0) return {0, 0, "it has no dimension"};
  if (is_declared && info.batch_axis >= info.rank)
    return {0, 0, "the engine names an axis beyond its rank"};
  if (!is_declared && input && info.rank < 2)
    return {0, 0, "its only dimension belongs to one frame"};
  const uint32_t axis = is_declared ? info.batch_axis : 0;
  return {axis, info.shape[axis], ""};
}

// Why the axis cannot hold the frames of a batch.
std::string obstacle(const weir_tensor_info& info, const Axis& axis) {
  if (!axis.missing.empty()) return axis.missing;
  return "dimension " + std::to_string(info.rank - 1 - axis.axis) + " is " +
         std::to_string(axis.length);
}

bool known(const weir_tensor_info& info) {
  return info.rank != WEIR_RANK_UNKNOWN && info.type < WEIR_TYPE_END &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t d) { return d > 0; });
}

// True if `batch` equals `frame` with an extent `times` as long on the axis.
bool scales(const weir_tensor_info& frame, const weir_tensor_info& batch, uint32_t axis,
            size_t times) {
  if (frame.rank != batch.rank || axis >= frame.rank || frame.type != batch.type) return false;
  for (uint32_t i = 0; i < frame.rank; ++i)
    if (batch.shape[i] != frame.shape[i] * (i == axis ? static_cast<int64_t>(times) : 1))
      return false;
  return true;
}

}  // namespace

Result<BatchAxes> find_batch_axes(uint32_t flags, const Infos& inputs, const Infos& outputs,
                                  size_t batch_size) {
  if (flags & WEIR_MODEL_STATEFUL)
    return Error{.code = Code::BATCH_UNSUPPORTED,
                 .what =
                     "the model keeps state from frame to frame, and a batch would mix the state "
                     "of its frames",
                 .offered = "batch-size=" + std::to_string(batch_size),
                 .needed = "a model without state",
                 .fix = "set batch-size=1 and give each stream its own tensor_filter"};
  BatchAxes axes;
  const auto wanted = static_cast<int64_t>(batch_size);
  int64_t other = 0;  // a length common to all tensors that is not batch_size
  bool agree = true;
  std::string difference;
  const auto look = [&](const char* role, const Infos& infos, std::vector<uint32_t>* found) {
    for (size_t i = 0; i < infos.size(); ++i) {
      const Axis axis = find_axis(infos[i], &infos == &inputs);
      found->push_back(axis.axis);
      const bool fits = axis.length == -1 || axis.length == wanted;
      axes.fixed = axes.fixed || axis.length == wanted;
      agree = agree && axis.missing.empty() && axis.length > 1 && (!other || axis.length == other);
      other = axis.length;
      if (fits || !difference.empty()) continue;
      difference = name_of_tensor(role, i, infos[i]) + ": " + obstacle(infos[i], axis);
    }
  };
  look("input", inputs, &axes.inputs);
  look("output", outputs, &axes.outputs);
  if (difference.empty() && !inputs.empty() && !outputs.empty()) return axes;
  return unsupported("the model cannot run " + std::to_string(batch_size) + " frames at once",
                     inputs, outputs, batch_size, difference,
                     agree ? "batch-size=" + std::to_string(other) : kExport);
}

Infos of_one_frame(Infos tensors, const std::vector<uint32_t>& axes, size_t batch_size) {
  for (size_t i = 0; i < tensors.size(); ++i)
    if (auto& info = tensors[i]; info.rank != WEIR_RANK_UNKNOWN && axes[i] < info.rank &&
                                 info.shape[axes[i]] == static_cast<int64_t>(batch_size))
      info.shape[axes[i]] = 1;
  return tensors;
}

Infos of_frames(Infos tensors, const std::vector<uint32_t>& axes, size_t frames) {
  for (size_t i = 0; i < tensors.size(); ++i)
    tensors[i].shape[axes[i]] *= static_cast<int64_t>(frames);
  return tensors;
}

Result<BatchShapes> shapes_of_batch(const BatchAxes& axes, size_t batch_size, const Infos& frame,
                                    const ResolveShapes& resolve) {
  BatchShapes out{axes, batch_size, frame, {}};
  const auto refused = [&](const Infos& outputs, const std::string& difference) {
    return unsupported(
        "the model's outputs cannot be split into one part per frame of a batch",
        of_frames(frame, axes.inputs, batch_size), outputs, batch_size, difference,
        "set batch-size=1, or export the model so that each output begins with the axis of the "
        "batch");
  };
  if (!axes.fixed) {
    auto one = resolve(frame);
    if (!one) return one.error();
    out.outputs = *std::move(one);
  }
  auto all = resolve(of_frames(frame, axes.inputs, batch_size));
  if (!all) {
    Error error = all.error();
    if (error.fix.empty()) error.fix = kExport;
    return error;
  }
  if (axes.fixed) out.outputs = of_one_frame(*all, axes.outputs, batch_size);
  for (size_t i = 0; i < all->size(); ++i) {
    const auto who = name_of_tensor("output", i, (*all)[i]);
    if (!known((*all)[i]) || !known(out.outputs[i]))
      return refused(*all, who + ": its size is unknown before the invoke");
    if (!scales(out.outputs[i], (*all)[i], axes.outputs[i], batch_size))
      return refused(*all, who + ": " + to_string((*all)[i]) + " for " +
                               std::to_string(batch_size) + " frames, " +
                               to_string(out.outputs[i]) + " for one");
  }
  return out;
}

}  // namespace weir::infer
