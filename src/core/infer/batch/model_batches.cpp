// Creates the group of a model: a session, its shapes and the cost of changing them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/model_batches.hpp"

#include <chrono>

namespace weir::infer {
namespace {

using Infos = std::vector<weir_tensor_info>;

// The model's groups. Each of them holds a reference to this and keeps the model open.
struct Batches {
  BatchGroups groups;
};

Result<std::shared_ptr<BatchGroup>> make_group(const std::shared_ptr<Batches>& batches,
                                               const std::shared_ptr<SharedModel>& shared,
                                               const BatchAxes& axes, size_t batch_size,
                                               const Infos& frame) {
  auto created = ModelLease::create(shared, 1, ModelLease::For::Others);
  if (!created) return created.error();
  const std::shared_ptr<ModelLease> use = *std::move(created);
  std::vector<std::vector<ModelTensor>> resolved;  // own the names that infos point to
  std::chrono::nanoseconds reshape{};
  auto shapes = shapes_of_batch(axes, batch_size, frame, [&](const Infos& inputs) -> Result<Infos> {
    const auto begin = std::chrono::steady_clock::now();
    auto outputs = use->resolve(model_tensors(inputs));
    if (!outputs) return outputs.error();
    reshape = std::chrono::steady_clock::now() - begin;
    resolved.push_back(*std::move(outputs));
    return tensor_infos(resolved.back());
  });
  if (!shapes) return shapes.error();
  InputMemory memory;
  {
    auto now = use->begin();
    if (!now) return now.error();
    memory = {now->model().info().alignment, now->model().info().input_padding};
  }
  return std::make_shared<BatchGroup>(
      *std::move(shapes), memory, reshape,
      [use, batches](const weir_frame& in, weir_frame& out, InvokeEnd* end) -> Result<bool> {
        auto model = use->begin();
        if (!model) return model.error();
        return model->session().invoke(in, out, end);
      });
}

}  // namespace

Result<ModelBatch> join_model_batch(const std::shared_ptr<SharedModel>& shared,
                                    const BatchAxes& axes, size_t batch_size,
                                    const std::vector<ModelTensor>& frame) {
  const auto batches = shared->attached<Batches>([] { return std::make_shared<Batches>(); });
  const Infos inputs = tensor_infos(frame);
  auto group = batches->groups.find(
      batch_size, inputs, [&] { return make_group(batches, shared, axes, batch_size, inputs); });
  if (!group) return group.error();
  return ModelBatch{*group, model_tensors((*group)->shapes().outputs)};
}

}  // namespace weir::infer
