// Replaces the model on its own thread, and suspends it after a time without frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_lifecycle.hpp"

#include <string>
#include <utility>
#include <vector>

#include "weir/join.hpp"

namespace weir {
namespace {

// Reads a string or a list of strings.
std::string files_of(const GValue* value) {
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
  return files_of(gst_structure_get_value(gst_event_get_structure(event), "model_files"));
}

void ModelLifecycle::start(std::shared_ptr<const OpenModel> model, const FilterSettings& settings) {
  idle_.reset();
  if (settings.suspend > 0)
    idle_ = std::make_unique<IdleWatch>(TimerQueue::instance(),
                                        std::chrono::milliseconds(settings.suspend),
                                        [model = std::move(model)] { return model->suspend(); });
  std::lock_guard lock(mutex_);
  runs_ = true;
}

void ModelLifecycle::stop() noexcept {
  idle_.reset();
  std::thread thread;
  {
    std::lock_guard lock(mutex_);
    runs_ = false;
    wanted_.reset();
    thread = std::move(thread_);
  }
  if (thread.joinable()) thread.join();
}

void ModelLifecycle::replace_later(std::string model, Replace replace) {
  std::lock_guard lock(mutex_);
  if (!runs_) return;
  wanted_ = std::move(model);
  replace_ = std::move(replace);
  if (replacing_) return;
  if (thread_.joinable()) thread_.join();  // it has ended or is about to
  thread_ = std::thread([this] { replace_all(); });
  replacing_ = true;
}

void ModelLifecycle::replace_all() {
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

}  // namespace weir
