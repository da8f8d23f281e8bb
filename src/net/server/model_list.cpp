// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/model_list.hpp"

#include <algorithm>

namespace weir::net {

Status ModelList::add(const std::shared_ptr<ServedModel>& model, const std::string& address) {
  {
    std::lock_guard lock(mutex_);
    for (const auto& other : models_)
      if (other->model().name == model->model().name &&
          other->model().version == model->model().version)
        return Error{.code = Code::OPTION_VALUE,
                     .what = "two elements serve a model with the same name on one address",
                     .offered = describe(model->model()) + " on " + address,
                     .needed = "a different name or version for each",
                     .fix = "model-name=" + model->model().name + "-2"};
    models_.push_back(model);
    std::erase_if(gone_,
                  [&](const auto& gone) { return describe(gone) == describe(model->model()); });
  }
  model->set_observer([weak = weak_from_this()] {
    if (const auto list = weak.lock()) list->update();
  });
  update();
  return ok();
}

void ModelList::remove(const ServedModel& model) {
  {
    std::lock_guard lock(mutex_);
    if (std::erase_if(models_, [&](const auto& other) { return other.get() == &model; }) != 0)
      gone_.push_back(model.model());
  }
  update();
}

ModelList::Models ModelList::all() const {
  std::lock_guard lock(mutex_);
  return models_;
}

std::shared_ptr<ServedModel> ModelList::find(const ModelRequest& wanted) const {
  std::lock_guard lock(mutex_);
  const auto found = std::find_if(models_.begin(), models_.end(),
                                  [&](const auto& model) { return fits(wanted, model->model()); });
  return found == models_.end() ? nullptr : *found;
}

bool ModelList::was_here(const ModelRequest& wanted) const {
  std::lock_guard lock(mutex_);
  return std::any_of(gone_.begin(), gone_.end(),
                     [&](const auto& gone) { return fits(wanted, gone); });
}

std::vector<IndexedModel> ModelList::index() const {
  std::lock_guard lock(mutex_);
  std::vector<IndexedModel> out;
  for (const auto& model : models_) {
    const bool ready = model->ready();
    out.push_back({model->model(), ready,
                   ready                ? ""
                   : model->is_loaded() ? "its pipeline does not run"
                                        : "unloaded"});
  }
  for (const auto& gone : gone_) out.push_back({gone, false, "its pipeline does not run"});
  return out;
}

std::string ModelList::names() const {
  std::string out;
  for (const auto& model : all()) out += (out.empty() ? "" : ", ") + describe(model->model());
  return out.empty() ? "none" : out;
}

bool ModelList::has_version_locked(const std::string& name) const {
  return std::any_of(models_.begin(), models_.end(),
                     [&](const auto& model) { return model->model().name == name; });
}

Health ModelList::health_locked(const std::string& service) const {
  const bool whole = service.empty() || service == "inference.GRPCInferenceService";
  bool known = whole, ready = !closed_ && !models_.empty();
  for (const auto& model : models_) {
    if (!whole && model->model().name != service) continue;
    known = true;
    ready = ready && model->ready();
  }
  for (const auto& gone : gone_) {
    if ((!whole && gone.name != service) || has_version_locked(gone.name)) continue;
    known = true;
    ready = false;
  }
  return !known ? Health::Unknown : ready ? Health::Serving : Health::NotServing;
}

Health ModelList::health(const std::string& service) const {
  std::lock_guard lock(mutex_);
  return health_locked(service);
}

void ModelList::watch(std::shared_ptr<Call> call, const std::string& service) {
  std::lock_guard lock(mutex_);
  std::erase_if(watchers_, [](const auto& watcher) { return watcher.call->ended(); });
  const Health now = health_locked(service);
  call->send(encode_health(static_cast<int>(now)));
  if (closed_)
    call->fail(CallStatus::Unavailable, "the server is stopping");
  else
    watchers_.push_back({std::move(call), service, now});
}

// Sends under the lock, so that the last message that a watcher gets is the newest.
void ModelList::update() {
  std::lock_guard lock(mutex_);
  std::erase_if(watchers_, [this](auto& watcher) {
    const Health now = health_locked(watcher.service);
    if (now == watcher.sent) return watcher.call->ended();
    watcher.sent = now;
    return !watcher.call->send(encode_health(static_cast<int>(now)));
  });
}

void ModelList::close() {
  std::vector<Watcher> watchers;
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
    watchers.swap(watchers_);
  }
  for (const auto& watcher : watchers) {
    if (watcher.sent != Health::NotServing)
      watcher.call->send(encode_health(static_cast<int>(Health::NotServing)));
    watcher.call->fail(CallStatus::Unavailable, "the server is stopping");
  }
}

}  // namespace weir::net
