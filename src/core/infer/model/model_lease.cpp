// Creates, resolves, suspends and resumes the sessions of one filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>

#include "core/infer/model/shared_model.hpp"
#include "core/infer/model/warm_up.hpp"
#include "core/infer/model/worker_sessions.hpp"

namespace weir::infer {

namespace {

std::atomic<uint64_t> sets{0};

}  // namespace

ModelLease::Sessions::Sessions(std::shared_ptr<Model> model)
    : model_(std::move(model)), number_(++sets) {}

Result<std::shared_ptr<ModelLease::Sessions>> ModelLease::Sessions::create(
    std::shared_ptr<Model> model, size_t count) {
  auto made = worker_sessions(*model, count);
  if (!made) return made.error();
  made->erase(std::unique(made->begin(), made->end()), made->end());
  std::shared_ptr<Sessions> set(new Sessions(std::move(model)));
  set->all_ = *std::move(made);
  return set;
}

void ModelLease::Sessions::hold() {
  std::lock_guard lock(mutex_);
  ++holds_;
}
void ModelLease::Sessions::release() {
  std::lock_guard lock(mutex_);
  if (--holds_ == 0) free_.notify_all();
}
bool ModelLease::Sessions::held() const {
  std::lock_guard lock(mutex_);
  return holds_ > 0;
}
bool ModelLease::Sessions::wait_until_free(std::chrono::milliseconds limit) const {
  std::unique_lock lock(mutex_);
  return free_.wait_for(lock, limit, [this] { return holds_ == 0; });
}

Result<std::unique_ptr<ModelLease>> ModelLease::create(const std::shared_ptr<SharedModel>& shared,
                                                       size_t sessions, For user) {
  std::lock_guard opening(shared->opening_);
  const auto model = shared->ensure_open();
  if (!model) return model.error();
  std::unique_ptr<ModelLease> use(new ModelLease(shared, sessions, user));
  auto set = Sessions::create(*model, sessions);
  if (!set) return set.error();
  use->set_ = *std::move(set);
  std::lock_guard lock(shared->mutex_);
  shared->model_ = *model;  // the last other lease may have closed it in the meantime
  shared->uses_.push_back(use.get());
  return use;
}

ModelLease::~ModelLease() {
  shared_->remove(this);
}

Result<ModelLease::Frame> ModelLease::begin() {
  for (;;) {
    {
      std::lock_guard lock(mutex_);
      if (set_ && asleep_) {
        for (const auto& session : set_->all())
          if (auto status = session->control(WEIR_RESUME); !status) return status.error();
        asleep_ = false;
      }
      if (set_) {
        set_->hold();
        return Frame(set_);
      }
    }
    if (auto status = reopen(); !status) return status.error();
  }
}

Status ModelLease::reopen() {
  std::lock_guard opening(shared_->opening_);
  const auto model = shared_->ensure_open();
  if (!model) return model.error();
  Shapes shapes;
  {
    std::lock_guard lock(mutex_);
    if (set_) return ok();  // another thread was first
    shapes = shapes_;
  }
  auto set = prepared(*model, sessions_, shapes, false);
  if (!set) return set.error();
  std::lock_guard lock(shared_->mutex_);
  std::lock_guard own(mutex_);
  shared_->model_ = *model;
  set_ = *std::move(set);
  return ok();
}

Result<std::vector<ModelTensor>> ModelLease::resolve(const std::vector<ModelTensor>& inputs) {
  const auto infos = tensor_infos(inputs);
  for (;;) {
    auto frame = begin();
    if (!frame) return frame.error();
    auto outputs = model_tensors(frame->model().outputs());
    for (const auto& session : frame->set_->all()) {
      const auto resolved = session->resolve(infos);
      if (!resolved) return resolved.error();
      outputs = model_tensors(*resolved);
    }
    std::lock_guard lock(mutex_);
    if (frame->set_ != set_) continue;  // replaced in the meantime
    shapes_ = {shapes_.version + 1, true, inputs, outputs};
    return outputs;
  }
}

Result<std::vector<ModelTensor>> ModelLease::resolve(const Frame& frame, size_t worker,
                                                     const std::vector<ModelTensor>& inputs) {
  const auto resolved = frame.session(worker).resolve(tensor_infos(inputs));
  if (!resolved) return resolved.error();
  auto outputs = model_tensors(*resolved);
  std::lock_guard lock(mutex_);
  if (frame.set_ == set_) shapes_ = {shapes_.version + 1, true, inputs, outputs};
  return outputs;
}

Result<std::shared_ptr<ModelLease::Sessions>> ModelLease::prepared(std::shared_ptr<Model> model,
                                                                   size_t sessions,
                                                                   const Shapes& shapes,
                                                                   bool warm) {
  auto set = Sessions::create(std::move(model), sessions);
  if (!set) return set.error();
  for (const auto& session : (*set)->all())
    if (auto status = prepare(*session, shapes, warm); !status) return status.error();
  return set;
}

Status ModelLease::prepare(Session& session, const Shapes& shapes, bool warm) {
  if (!shapes.resolved) return ok();
  const auto outputs = session.resolve(tensor_infos(shapes.inputs));
  if (!outputs) return outputs.error();
  const auto found = model_tensors(*outputs);
  const auto difference = first_difference(found, shapes.outputs, "output");
  if (!difference.empty())
    return Error{
        .code = Code::MODEL_DIFFERS,
        .what = "the new model has different outputs for the inputs of this stream",
        .offered = list_tensors(found),
        .needed = list_tensors(shapes.outputs),
        .difference = difference,
        .fix = "use a model with the same outputs, or set it while the element is stopped"};
  return warm ? warm_up(session, shapes.inputs, found) : ok();
}

bool ModelLease::suspend() {
  std::shared_ptr<Sessions> closing;
  {
    std::lock_guard lock(mutex_);
    if (!set_ || asleep_) return true;
    if (set_->held()) return false;
    const auto& sessions = set_->all();
    // Never suspend a session that has other users.
    asleep_ =
        !sessions.empty() && std::all_of(sessions.begin(), sessions.end(), [](const auto& session) {
          return session.use_count() == 1 && bool(session->control(WEIR_SUSPEND));
        });
    if (asleep_) return true;
    closing = std::move(set_);
    set_ = nullptr;
    closing_ = true;
  }
  closing.reset();
  shared_->close_if_unused();
  std::lock_guard lock(mutex_);
  closing_ = false;
  return true;
}

bool ModelLease::suspended() const {
  std::lock_guard lock(mutex_);
  return asleep_ || (!set_ && !closing_);
}

}  // namespace weir::infer
