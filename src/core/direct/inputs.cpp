// Nothing that a program says of its memory is believed that can be checked.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/inputs.hpp"

#include <cstring>

#include "core/direct/tensor_words.hpp"
#include "core/infer/host.hpp"
#include "core/tensor/element_type.hpp"

namespace weir::direct {
namespace {

std::string list(const std::vector<weir_tensor_info>& infos) {
  std::string out;
  for (const auto& info : infos) out += (out.empty() ? "" : ", ") + words(info);
  return out.empty() ? "none" : out;
}

bool in_place(const weir_tensor& tensor, const MemoryNeeds& needs) {
  const uint64_t readable = tensor.capacity > tensor.bytes ? tensor.capacity : tensor.bytes;
  return reinterpret_cast<uintptr_t>(tensor.data) % needs.alignment == 0 &&
         readable >= tensor.bytes + needs.padding;
}

std::string literal(const weir_tensor_info& info) {
  std::string out = shape_words(info);
  for (char& c : out) c = c == '(' ? '{' : c == ')' ? '}' : c == '?' ? '1' : c;
  if (const size_t comma = out.find(",}"); comma != std::string::npos) out.erase(comma, 1);
  return out;
}

Error left_open(size_t index, const weir_tensor_info& model) {
  return Error{Code::SPEC_MISMATCH,
               "the model leaves a shape open, and the call does not say it",
               place_words("input", index, model) + ": " + words(model),
               "a shape with every extent",
               "",
               model.rank > WEIR_RANK_LIMIT ? "" : "model.reshape({" + literal(model) + "})"};
}

}  // namespace

Status check_type(const weir_tensor& given, const weir_tensor_info& model, const char* role,
                  size_t index) {
  if (given.info.type >= WEIR_TYPE_END)
    return Error{Code::TYPE_SYNTAX,
                 place_words(role, index, model) + " has a type that is not known",
                 std::to_string(given.info.type),
                 "below " + std::to_string(WEIR_TYPE_END) + " (enum weir_type)",
                 "",
                 ""};
  if (model.type == WEIR_TYPE_END || model.type == given.info.type) return ok();
  return Error{Code::SPEC_MISMATCH,
               place_words(role, index, model) + " has another type than the model's",
               std::string(name_of(static_cast<ElementType>(given.info.type))),
               std::string(name_of(static_cast<ElementType>(model.type))),
               "",
               ""};
}

Status check_size(const weir_tensor& given, const weir_tensor_info& needed, const char* role,
                  size_t index) {
  const std::string who = place_words(role, index, needed);
  const auto bytes = bytes_of(needed);
  if (!bytes)
    return Error{Code::LIMIT_EXCEEDED, who + " is too large", words(needed), "2^48 bytes", "", ""};
  if (*bytes != given.bytes)
    return Error{Code::FRAME_SIZE,
                 who + " has another size than its shape says",
                 std::to_string(given.bytes) + " bytes",
                 std::to_string(*bytes) + " bytes: " + words(needed),
                 "",
                 ""};
  if (!given.data && *bytes > 0)
    return Error{Code::FRAME_SIZE, who + " has no memory", "a null pointer", words(needed), "", ""};
  if (given.memory_kind != WEIR_MEMORY_HOST)
    return Error{Code::FORMAT_UNSUPPORTED,
                 who + " is not in host memory",
                 "memory kind " + std::to_string(given.memory_kind),
                 "host memory",
                 "",
                 ""};
  return ok();
}

Result<std::vector<weir_tensor_info>> described_inputs(
    std::span<const weir_tensor> given, const std::vector<weir_tensor_info>& declared,
    const std::vector<weir_tensor_info>& current) {
  if (given.size() != declared.size())
    return Error{
        Code::SPEC_MISMATCH,          "the model takes another number of tensors",
        std::to_string(given.size()), std::to_string(declared.size()) + ": " + list(declared),
        "number of tensors",          ""};
  std::vector<weir_tensor_info> out = current;
  for (size_t i = 0; i < given.size(); ++i) {
    if (auto status = check_type(given[i], declared[i], "input", i); !status) return status.error();
    const weir_tensor_info& wish = given[i].info;
    out[i].type = wish.type;
    if (wish.rank <= WEIR_RANK_LIMIT) {
      const std::string difference = shape_difference(wish, declared[i]);
      if (!difference.empty() || !is_fixed(wish))
        return Error{Code::SPEC_MISMATCH,
                     place_words("input", i, declared[i]) + " has another shape than the model's",
                     words(wish),
                     words(declared[i]),
                     difference.empty() ? "an extent is not known" : difference,
                     ""};
      out[i].rank = wish.rank;
      std::memcpy(out[i].shape, wish.shape, sizeof wish.shape);
    } else if (!is_fixed(out[i])) {
      return left_open(i, declared[i]);
    }
    if (auto status = check_size(given[i], out[i], "input", i); !status) return status.error();
  }
  return out;
}

Result<std::vector<weir_tensor_info>> reshaped(const std::vector<weir_tensor_info>& declared,
                                               std::span<const weir_tensor_info> wanted) {
  if (wanted.size() != declared.size())
    return Error{Code::SPEC_MISMATCH,
                 "the model has another number of inputs",
                 std::to_string(wanted.size()) + " shapes",
                 std::to_string(declared.size()) + ": " + list(declared),
                 "number of tensors",
                 ""};
  std::vector<weir_tensor_info> out = declared;
  for (size_t i = 0; i < out.size(); ++i) {
    const weir_tensor_info& wish = wanted[i];
    if (wish.type < WEIR_TYPE_END) {
      weir_tensor typed{};
      typed.info.type = out[i].type = wish.type;
      if (auto status = check_type(typed, declared[i], "input", i); !status) return status.error();
    }
    if (wish.rank > WEIR_RANK_LIMIT) continue;
    std::string difference = shape_difference(wish, declared[i]);
    for (uint32_t axis = 0; axis < wish.rank && difference.empty(); ++axis)
      if (wish.shape[axis] < 1)
        difference = "axis " + std::to_string(axis) + " is " + std::to_string(wish.shape[axis]);
    if (!difference.empty())
      return Error{
          Code::SPEC_MISMATCH, place_words("input", i, declared[i]) + " cannot have this shape",
          shape_words(wish),   words(declared[i]),
          difference,          ""};
    out[i].rank = wish.rank;
    std::memcpy(out[i].shape, wish.shape, sizeof wish.shape);
  }
  return out;
}

Status check_outputs(std::span<const weir_tensor> given,
                     const std::vector<weir_tensor_info>& outputs) {
  if (given.empty()) return ok();
  if (given.size() != outputs.size())
    return Error{Code::SPEC_MISMATCH,
                 "the model gives another number of tensors",
                 "memory for " + std::to_string(given.size()),
                 std::to_string(outputs.size()) + ": " + list(outputs),
                 "number of tensors",
                 ""};
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
        return Error{Code::OUT_OF_MEMORY, "no memory for an input", words(infos[i]), "", "", ""};
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
