// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/warm_up.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>

#include "core/tensor/model_tensor.hpp"

namespace weir::infer {
namespace {

// Tensors that own their memory, if every size is known.
class Tensors {
 public:
  Tensors(const std::vector<ModelTensor>& shapes, size_t alignment, size_t padding, bool allocate)
      : tensors_(shapes.size()), memory_(shapes.size()) {
    for (size_t i = 0; i < shapes.size(); ++i) {
      tensors_[i].info = tensor_info(shapes[i]);
      tensors_[i].memory_kind = WEIR_MEMORY_HOST;
      tensors_[i].fence_fd = -1;
      if (!allocate) continue;
      const size_t bytes = to_spec(shapes[i]).bytes().value_or(0);
      memory_[i].resize(bytes + padding + alignment);
      void* at = memory_[i].data();
      size_t room = memory_[i].size();
      std::align(alignment, bytes + padding, at, room);
      tensors_[i].data = at;
      tensors_[i].bytes = bytes;
      tensors_[i].capacity = bytes + padding;
    }
  }
  ~Tensors() {
    for (auto& tensor : tensors_)
      if (tensor.release) tensor.release(tensor.owner);
  }
  Tensors(const Tensors&) = delete;
  Tensors& operator=(const Tensors&) = delete;

  weir_frame frame() {
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors_.size());
    frame.tensors = tensors_.data();
    frame.pts = frame.duration = frame.deadline = -1;
    return frame;
  }

 private:
  std::vector<weir_tensor> tensors_;
  std::vector<std::vector<std::byte>> memory_;
};

bool fixed(const std::vector<ModelTensor>& shapes) {
  return std::all_of(shapes.begin(), shapes.end(), [](const auto& s) { return s.fixed(); });
}

}  // namespace

Status warm_up(Session& session, const std::vector<ModelTensor>& inputs,
               const std::vector<ModelTensor>& outputs) {
  return session.control(WEIR_WARM) ? ok() : invoke_zeros(session, inputs, outputs);
}

Status invoke_zeros(Session& session, const std::vector<ModelTensor>& inputs,
                    const std::vector<ModelTensor>& outputs) {
  const auto& info = session.model().info();
  if (!fixed(inputs) || inputs.size() != info.n_inputs || (info.flags & WEIR_MODEL_STATEFUL) != 0)
    return ok();
  Tensors in(inputs, std::max(1u, info.alignment), info.input_padding, true);
  Tensors out(outputs, 1, 0, fixed(outputs));
  const weir_frame in_frame = in.frame();
  weir_frame out_frame = out.frame();
  const auto kept = session.invoke(in_frame, out_frame);
  return kept ? ok() : Status(kept.error());
}

}  // namespace weir::infer
