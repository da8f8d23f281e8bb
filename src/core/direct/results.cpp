// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/results.hpp"

#include <cstring>
#include <utility>

#include "core/direct/inputs.hpp"
#include "core/direct/tensor_text.hpp"
#include "core/infer/module/host.hpp"

namespace weir::direct {

Results::Results(const std::vector<weir_tensor_info>& outputs) : tensors_(outputs.size()) {
  for (const auto& info : outputs) names_.emplace_back(info.name ? info.name : "");
  for (size_t i = 0; i < outputs.size(); ++i) {
    weir_tensor& tensor = tensors_[i];
    tensor.info = outputs[i];
    tensor.info.name = names_[i].c_str();
    tensor.memory_kind = WEIR_MEMORY_HOST;
    tensor.fence_fd = -1;
    tensor.bytes = count_bytes(outputs[i]).value_or(0);
  }
}

Results::Results(Results&& other) noexcept
    : names_(std::move(other.names_)),
      tensors_(std::exchange(other.tensors_, {})),
      frames_(other.frames_) {}

Results& Results::operator=(Results&& other) noexcept {
  if (this == &other) return *this;
  release();
  names_ = std::move(other.names_);
  tensors_ = std::exchange(other.tensors_, {});
  frames_ = other.frames_;
  return *this;
}

Results::~Results() {
  release();
}

void Results::release() noexcept {
  for (auto& tensor : tensors_)
    if (tensor.release) tensor.release(tensor.owner);
  tensors_.clear();
}

Status Results::allocate(uint32_t alignment) {
  for (auto& tensor : tensors_) {
    if (tensor.data || !is_fixed(tensor.info)) continue;
    const auto bytes = count_bytes(tensor.info);
    if (!bytes || infer::host().allocate(nullptr, WEIR_MEMORY_HOST, *bytes, alignment, &tensor) < 0)
      return Error{.code = Code::OUT_OF_MEMORY,
                   .what = "no memory for an output",
                   .offered = to_string(tensor.info)};
  }
  return ok();
}

void Results::lend(size_t index, void* data, uint64_t bytes) noexcept {
  tensors_[index].data = data;
  tensors_[index].bytes = tensors_[index].capacity = bytes;
}

Status Results::check() const {
  for (size_t i = 0; i < tensors_.size(); ++i) {
    const weir_tensor& tensor = tensors_[i];
    const auto needed = count_bytes(tensor.info);
    if (!needed || *needed != tensor.bytes || (!tensor.data && tensor.bytes > 0))
      return Error{.code = Code::INVOKE_FAILED,
                   .what = "the engine returned an output without a complete description",
                   .offered = place_text("output", i, tensor.info) + ": " +
                              std::to_string(tensor.bytes) + " bytes of " + to_string(tensor.info),
                   .needed = "memory of the size of its shape"};
  }
  return ok();
}

Status Results::copy_to(std::span<weir_tensor> into) const {
  for (size_t i = 0; i < into.size(); ++i) {
    const weir_tensor& from = tensors_[i];
    if (from.data != into[i].data) {
      if (auto status = check_type(into[i], from.info, "output", i); !status) return status;
      if (auto status = check_size(into[i], from.info, "output", i); !status) return status;
      if (from.bytes > 0) std::memcpy(into[i].data, from.data, from.bytes);
    }
    into[i].info = from.info;
    into[i].info.name = nullptr;
  }
  return ok();
}

weir_tensor Results::of_frame(uint32_t frame, size_t index) const noexcept {
  weir_tensor out = tensors_[index];
  out.release = nullptr;
  out.owner = nullptr;
  if (frames_ == 1) return out;
  out.bytes /= frames_;
  out.capacity -= frame * out.bytes;
  out.data = static_cast<char*>(out.data) + frame * out.bytes;
  out.info.shape[0] = 1;
  return out;
}

}  // namespace weir::direct
