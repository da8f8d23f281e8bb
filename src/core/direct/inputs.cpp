// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/inputs.hpp"

#include <cstring>

#include "core/direct/tensor_text.hpp"
#include "core/infer/module/host.hpp"
#include "core/tensor/element_type.hpp"
#include "weir/join.hpp"

namespace weir::direct {
namespace {

std::string list(const std::vector<weir_tensor_info>& infos) {
  const std::string out = join(infos, ", ", [](const auto& info) { return to_string(info); });
  return out.empty() ? "none" : out;
}

bool in_place(const weir_tensor& tensor, const MemoryNeeds& needs) {
  const uint64_t readable = tensor.capacity > tensor.bytes ? tensor.capacity : tensor.bytes;
  return reinterpret_cast<uintptr_t>(tensor.data) % needs.alignment == 0 &&
         readable >= tensor.bytes + needs.padding;
}

std::string literal(const weir_tensor_info& info) {
  std::string out = shape_text(info);
  for (char& c : out) c = c == '(' ? '{' : c == ')' ? '}' : c == '?' ? '1' : c;
  if (const size_t comma = out.find(",}"); comma != std::string::npos) out.erase(comma, 1);
  return out;
}

Error left_open(size_t index, const weir_tensor_info& model) {
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what = "the model leaves a shape open, and the call does not set it",
      .offered = place_text("input", index, model) + ": " + to_string(model),
      .needed = "a complete shape",
      .fix = model.rank > WEIR_RANK_LIMIT ? "" : "model.reshape({" + literal(model) + "})"};
}

}  // namespace

Status check_type(const weir_tensor& given, const weir_tensor_info& model, const char* role,
                  size_t index) {
  if (given.info.type >= WEIR_TYPE_END)
    return Error{.code = Code::TYPE_SYNTAX,
                 .what = place_text(role, index, model) + " has an unknown type",
                 .offered = std::to_string(given.info.type),
                 .needed = "below " + std::to_string(WEIR_TYPE_END) + " (enum weir_type)"};
  if (model.type == WEIR_TYPE_END || model.type == given.info.type) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = place_text(role, index, model) + " has a different type than the model's",
               .offered = std::string(to_string(static_cast<ElementType>(given.info.type))),
               .needed = std::string(to_string(static_cast<ElementType>(model.type)))};
}

Status check_size(const weir_tensor& given, const weir_tensor_info& needed, const char* role,
                  size_t index) {
  const std::string who = place_text(role, index, needed);
  const auto bytes = count_bytes(needed);
  if (!bytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = who + " is too large",
                 .offered = to_string(needed),
                 .needed = "2^48 bytes"};
  if (*bytes != given.bytes)
    return Error{.code = Code::FRAME_SIZE,
                 .what = who + " has a size that does not match its shape",
                 .offered = std::to_string(given.bytes) + " bytes",
                 .needed = std::to_string(*bytes) + " bytes: " + to_string(needed)};
  if (!given.data && *bytes > 0)
    return Error{.code = Code::FRAME_SIZE,
                 .what = who + " has no memory",
                 .offered = "a null pointer",
                 .needed = to_string(needed)};
  if (given.memory_kind != WEIR_MEMORY_HOST)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = who + " is not in host memory",
                 .offered = "memory kind " + std::to_string(given.memory_kind),
                 .needed = "host memory"};
  return ok();
}

namespace {

// Gives `out`, the current description of input i, the shape that comes with a frame, if one comes.
Status describe_shape(const weir_tensor_info& requested, const weir_tensor_info& declared, size_t i,
                      weir_tensor_info* out) {
  if (requested.rank > WEIR_RANK_LIMIT)
    return is_fixed(*out) ? ok() : Status(left_open(i, declared));
  const std::string difference = shape_difference(requested, declared);
  if (!difference.empty() || !is_fixed(requested))
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = place_text("input", i, declared) + " has a different shape than the model's",
        .offered = to_string(requested),
        .needed = to_string(declared),
        .difference = difference.empty() ? "an extent is unknown" : difference};
  out->rank = requested.rank;
  std::memcpy(out->shape, requested.shape, sizeof requested.shape);
  return ok();
}

// Gives `out`, the declaration of input i, the type and the shape that are requested.
Status reshape_input(const weir_tensor_info& requested, size_t i, weir_tensor_info* out) {
  const weir_tensor_info declared = *out;
  if (requested.type < WEIR_TYPE_END) {
    weir_tensor typed{};
    typed.info.type = out->type = requested.type;
    if (auto status = check_type(typed, declared, "input", i); !status) return status;
  }
  if (requested.rank > WEIR_RANK_LIMIT) return ok();
  std::string difference = shape_difference(requested, declared);
  for (uint32_t axis = 0; axis < requested.rank && difference.empty(); ++axis)
    if (requested.shape[axis] < 1)
      difference = "axis " + std::to_string(axis) + " is " + std::to_string(requested.shape[axis]);
  if (!difference.empty())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = place_text("input", i, declared) + " cannot have this shape",
                 .offered = shape_text(requested),
                 .needed = to_string(declared),
                 .difference = difference};
  out->rank = requested.rank;
  std::memcpy(out->shape, requested.shape, sizeof requested.shape);
  return ok();
}

}  // namespace

Result<std::vector<weir_tensor_info>> described_inputs(
    std::span<const weir_tensor> given, const std::vector<weir_tensor_info>& declared,
    const std::vector<weir_tensor_info>& current) {
  if (given.size() != declared.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the model has a different number of inputs",
                 .offered = std::to_string(given.size()),
                 .needed = std::to_string(declared.size()) + ": " + list(declared),
                 .difference = "number of tensors"};
  std::vector<weir_tensor_info> out = current;
  for (size_t i = 0; i < given.size(); ++i) {
    if (auto status = check_type(given[i], declared[i], "input", i); !status) return status.error();
    out[i].type = given[i].info.type;
    if (auto status = describe_shape(given[i].info, declared[i], i, &out[i]); !status)
      return status.error();
    if (auto status = check_size(given[i], out[i], "input", i); !status) return status.error();
  }
  return out;
}

Result<std::vector<weir_tensor_info>> reshaped(const std::vector<weir_tensor_info>& declared,
                                               std::span<const weir_tensor_info> wanted) {
  if (wanted.size() != declared.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the model has a different number of inputs",
                 .offered = std::to_string(wanted.size()) + " shapes",
                 .needed = std::to_string(declared.size()) + ": " + list(declared),
                 .difference = "number of tensors"};
  std::vector<weir_tensor_info> out = declared;
  for (size_t i = 0; i < out.size(); ++i)
    if (auto status = reshape_input(wanted[i], i, &out[i]); !status) return status.error();
  return out;
}

Status check_outputs(std::span<const weir_tensor> given,
                     const std::vector<weir_tensor_info>& outputs) {
  if (given.empty()) return ok();
  if (given.size() != outputs.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the model has a different number of outputs",
                 .offered = "memory for " + std::to_string(given.size()),
                 .needed = std::to_string(outputs.size()) + ": " + list(outputs),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < given.size(); ++i) {
    if (auto status = check_type(given[i], outputs[i], "output", i); !status) return status;
    if (!is_fixed(outputs[i])) continue;
    if (auto status = check_size(given[i], outputs[i], "output", i); !status) return status;
  }
  return ok();
}

Result<Inputs> Inputs::take(std::span<const weir_tensor> given,
                            const std::vector<weir_tensor_info>& infos, const MemoryNeeds& needs,
                            bool lasting) {
  Inputs out;
  out.copies_ = Results(infos);
  for (size_t i = 0; i < given.size(); ++i) {
    weir_tensor& tensor = out.copies_.tensors()[i];
    const uint64_t bytes = given[i].bytes;
    if (!lasting && in_place(given[i], needs)) {
      tensor.data = given[i].data;
      tensor.capacity = given[i].capacity > bytes ? given[i].capacity : bytes;
    } else {
      if (infer::host().allocate(nullptr, WEIR_MEMORY_HOST, bytes + needs.padding, needs.alignment,
                                 &tensor) < 0)
        return Error{.code = Code::OUT_OF_MEMORY,
                     .what = "no memory for an input",
                     .offered = to_string(infos[i])};
      if (bytes > 0) std::memcpy(tensor.data, given[i].data, bytes);
    }
    tensor.bytes = bytes;
    tensor.flags = WEIR_TENSOR_READONLY;
  }
  out.tensors_ = out.copies_.tensors();
  for (auto& tensor : out.tensors_) tensor.release = nullptr;
  return out;
}

}  // namespace weir::direct
