// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sink_callbacks.hpp"

#include <algorithm>
#include <new>

#include "tensors_data.hpp"

namespace weir::application {
namespace {

thread_local const void* running_pipeline = nullptr;

}  // namespace

const void* pipeline_of_callback() noexcept {
  return running_pipeline;
}

InCallback::InCallback(const void* pipeline) noexcept : before_(running_pipeline) {
  running_pipeline = pipeline;
}

InCallback::~InCallback() {
  running_pipeline = before_;
}

void SinkCallbacks::add(std::shared_ptr<SinkCallback> callback) {
  std::lock_guard lock(mutex_);
  callbacks_.push_back(std::move(callback));
}

void SinkCallbacks::remove(const std::shared_ptr<SinkCallback>& callback) {
  std::lock_guard lock(mutex_);
  std::erase(callbacks_, callback);
}

std::vector<std::shared_ptr<SinkCallback>> SinkCallbacks::all() const {
  std::lock_guard lock(mutex_);
  return callbacks_;
}

void SinkCallbacks::hand_over(const weir_pulled* frame) {
  const auto callbacks = all();
  if (callbacks.empty()) return;
  weir_pulled* kept = weir_pulled_keep(frame);
  if (!kept) throw std::bad_alloc();
  const std::shared_ptr<weir_pulled> owner(kept, weir_pulled_free);
  std::vector<weir_tensor> tensors(weir_pulled_count(frame));
  for (uint32_t i = 0; i < tensors.size(); ++i) weir_pulled_tensor(frame, i, &tensors[i]);
  const auto data = make_data(tensors, owner, TensorsData::Access::ReadOnly);
  const LentHandle data_handle(data);
  const LentHandle info_handle(std::make_shared<TensorsInfo>(data->tensors()));
  const InCallback here(pipeline_);
  for (const auto& callback : callbacks) {
    const infer::CallGate::Visit visit(callback->gate);
    if (visit) callback->function(data_handle.get(), info_handle.get(), callback->data);
  }
}

int SinkCallbacks::on_frame(const weir_pulled* frame, void* self, weir_error** error) {
  try {
    static_cast<SinkCallbacks*>(self)->hand_over(frame);
    return WEIR_OK;
  } catch (const std::exception& e) {
    *error = weir_error_new(WEIR_OUT_OF_MEMORY, e.what(), nullptr, nullptr, nullptr, nullptr);
    return -WEIR_OUT_OF_MEMORY;
  }
}

}  // namespace weir::application
