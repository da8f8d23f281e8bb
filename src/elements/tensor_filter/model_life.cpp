// Replacing on another thread, and sleeping by a watch.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_life.hpp"

#include <utility>

namespace weir {
namespace {

// A text, or a list of texts.
std::string files_of(const GValue* value) {
  std::string out;
  const auto add = [&out](const char* text) {
    if (text) out += (out.empty() ? "" : ",") + std::string(text);
  };
  if (!value) return out;
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
  return out;
}

}  // namespace

std::optional<std::string> wanted_model(GstEvent* event) {
  if (!gst_event_has_name(event, "evt_update_model")) return std::nullopt;
  return files_of(gst_structure_get_value(gst_event_get_structure(event), "model_files"));
}

void ModelLife::start(std::shared_ptr<const OpenedModel> model, const FilterSettings& settings) {
  if (settings.suspend > 0)
    idle_ = std::make_unique<IdleWatch>(TimerQueue::instance(),
                                        std::chrono::milliseconds(settings.suspend),
                                        [model] { return model->suspend(); });
  std::lock_guard lock(mutex_);
  model_ = std::move(model);
}

void ModelLife::stop() noexcept {
  idle_.reset();
  std::thread thread;
  {
    std::lock_guard lock(mutex_);
    model_.reset();
    wanted_.reset();
    thread = std::move(thread_);
  }
  if (thread.joinable()) thread.join();
}

Status ModelLife::replace(FilterSettings settings) const {
  std::unique_lock lock(mutex_);
  const auto model = model_;
  lock.unlock();
  return model ? model->replace(settings) : ok();
}

void ModelLife::replace_later(FilterSettings settings, Done done) {
  std::lock_guard lock(mutex_);
  if (!model_) return;
  wanted_ = std::move(settings);
  done_ = std::move(done);
  if (replacing_) return;
  if (thread_.joinable()) thread_.join();  // has ended, or is about to
  thread_ = std::thread([this] { replace_all(); });
  replacing_ = true;
}

void ModelLife::replace_all() {
  std::unique_lock lock(mutex_);
  while (wanted_) {
    const FilterSettings settings = *std::exchange(wanted_, std::nullopt);
    const Done done = done_;
    const auto model = model_;
    lock.unlock();
    if (model) done([&] { return model->replace(settings); }, settings.model);
    lock.lock();
  }
  replacing_ = false;
}

}  // namespace weir
