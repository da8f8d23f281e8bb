// Opens models without a lock and installs them if they are still current.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/running_model.hpp"

#include <utility>

namespace weir {

void RunningModel::start() {
  std::lock_guard lock(mutex_);
  stopped_ = false;
}

void RunningModel::stop() {
  std::lock_guard lock(mutex_);
  stopped_ = true;
  for (const auto* monitor : {&monitor_, &next_monitor_})
    if (*monitor) (*monitor)->stop();
}

void RunningModel::close() {
  Model ended;
  std::lock_guard lock(mutex_);
  ended.swap(model_);
}

bool RunningModel::stopped() const {
  std::lock_guard lock(mutex_);
  return stopped_;
}

// A model that is opened after stop() is cancelled, like one that was being opened.
uint64_t RunningModel::begin(std::shared_ptr<isolate::Monitor> monitor, FilterSettings* settings) {
  std::lock_guard lock(mutex_);
  if (model_) settings->model = file_;
  if (monitor && stopped_) monitor->stop();
  next_monitor_ = std::move(monitor);
  return replacements_;
}

Status RunningModel::open(FilterSettings* settings, const MakeMonitor& make_monitor,
                          const Check& check, std::vector<Error>* warnings) {
  for (;;) {
    auto monitor = make_monitor();
    const uint64_t before = begin(monitor, settings);
    warnings->clear();
    auto opened = OpenModel::open(*settings, monitor, warnings);
    if (!opened) return opened.error();
    if (auto status = check(**opened); !status) return status;
    Model model = *std::move(opened);  // the unused one of the two is closed without the lock
    std::lock_guard lock(mutex_);
    if (replacements_ != before) continue;
    model_.swap(model);
    monitor_ = std::move(monitor);
    file_ = settings->model;
    return ok();
  }
}

Status RunningModel::replace(const std::function<FilterSettings()>& settings) {
  for (;;) {
    const Model model = get();
    if (!model) return ok();
    const FilterSettings wanted = settings();
    Status status = model->replace(wanted);
    std::lock_guard lock(mutex_);
    if (model_ && model_ != model) continue;  // another thread installed a model meanwhile
    if (status) file_ = wanted.model, ++replacements_;
    return status;
  }
}

RunningModel::Model RunningModel::get() const {
  std::lock_guard lock(mutex_);
  return model_;
}

std::shared_ptr<isolate::Monitor> RunningModel::monitor() const {
  std::lock_guard lock(mutex_);
  return monitor_;
}

std::string RunningModel::file() const {
  std::lock_guard lock(mutex_);
  return file_;
}

}  // namespace weir
