// Opens models without a lock and installs them if they are still current; replaces them on a
// thread of its own, and suspends them after a time without frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/running_model.hpp"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "weir/join.hpp"

namespace weir {
namespace {

// Reads a string or a list of strings.
std::string get_files(const GValue* value) {
  std::vector<std::string> files;
  const auto add = [&files](const char* text) {
    if (text && *text) files.emplace_back(text);
  };
  if (!value) return {};
  if (G_VALUE_HOLDS_STRING(value)) {
    add(g_value_get_string(value));
  } else if (G_VALUE_HOLDS(value, G_TYPE_STRV)) {
    for (auto** text = static_cast<gchar**>(g_value_get_boxed(value)); text && *text; ++text)
      add(*text);
  } else if (GST_VALUE_HOLDS_ARRAY(value)) {
    for (guint i = 0; i < gst_value_array_get_size(value); ++i)
      if (const auto* part = gst_value_array_get_value(value, i); G_VALUE_HOLDS_STRING(part))
        add(g_value_get_string(part));
  }
  return join(files, ",");
}

}  // namespace

std::optional<std::string> wanted_model(GstEvent* event) {
  if (!gst_event_has_name(event, "evt_update_model")) return std::nullopt;
  return get_files(gst_structure_get_value(gst_event_get_structure(event), "model_files"));
}

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

void RunningModel::close() noexcept {
  idle_.reset();
  std::thread thread;
  {
    std::lock_guard lock(mutex_);
    replaces_ = false;
    wanted_.reset();
    thread = std::move(thread_);
  }
  if (thread.joinable()) thread.join();
  Model ended;  // is closed without the lock
  std::lock_guard lock(mutex_);
  ended.swap(model_);
}

bool RunningModel::stopped() const {
  std::lock_guard lock(mutex_);
  return stopped_;
}

Status RunningModel::open(FilterSettings* settings, const MakeMonitor& make_monitor,
                          const Check& check, std::vector<Error>* warnings) {
  if (auto status = install(settings, make_monitor, check, warnings); !status) return status;
  idle_.reset();
  if (settings->suspend > 0)
    idle_ = std::make_unique<IdleWatch>(TimerQueue::instance(),
                                        std::chrono::milliseconds(settings->suspend),
                                        [model = get()] { return model->suspend(); });
  std::lock_guard lock(mutex_);
  replaces_ = true;
  return ok();
}

Status RunningModel::install(FilterSettings* settings, const MakeMonitor& make_monitor,
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

// A model that is opened after stop() is cancelled, like one that was being opened.
uint64_t RunningModel::begin(std::shared_ptr<isolate::Monitor> monitor, FilterSettings* settings) {
  std::lock_guard lock(mutex_);
  if (model_) settings->model = file_;
  if (monitor && stopped_) monitor->stop();
  next_monitor_ = std::move(monitor);
  return replacements_;
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

void RunningModel::replace_later(std::string model, Replace replace) {
  std::lock_guard lock(mutex_);
  if (!replaces_) return;
  wanted_ = std::move(model);
  replace_ = std::move(replace);
  if (replacing_) return;
  if (thread_.joinable()) thread_.join();  // it has ended or is about to
  thread_ = std::thread([this] { replace_all(); });
  replacing_ = true;
}

void RunningModel::replace_all() {
  std::unique_lock lock(mutex_);
  while (wanted_) {
    const std::string model = *std::exchange(wanted_, std::nullopt);
    const Replace replace = replace_;
    lock.unlock();
    replace(model);
    lock.lock();
  }
  replacing_ = false;
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
