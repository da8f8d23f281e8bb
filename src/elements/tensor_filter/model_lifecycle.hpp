// ModelLifecycle: replaces and suspends the model of one tensor_filter while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/timer/idle_watch.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/open_model.hpp"

namespace weir {

// The field model_files of an event evt_update_model, in the format of the property model; "" if it
// cannot be read. nullopt for any other event.
std::optional<std::string> wanted_model(GstEvent* event);

// Thread-safe, except start() and stop().
class ModelLifecycle {
 public:
  // Replaces the model by the one of that name and reports the result. Must not throw.
  using Replace = std::function<void(const std::string& model)>;

  ~ModelLifecycle() { stop(); }
  // Call when `model` was installed with these settings; it may replace another one.
  void start(std::shared_ptr<const OpenModel> model, const FilterSettings& settings);
  // Waits for a running replacement. Afterwards nothing is replaced or suspended.
  void stop() noexcept;

  // Calls `replace` on a thread of its own. Of several requests that arrive meanwhile, only the
  // newest is kept.
  void replace_later(std::string model, Replace replace);

  // Call when a frame arrives and when it was processed.
  void touch() {
    if (idle_) idle_->touch();
  }

 private:
  void replace_all();

  std::mutex mutex_;  // guards the rest except idle_
  bool runs_ = false;
  std::optional<std::string> wanted_;
  Replace replace_;
  bool replacing_ = false;
  std::thread thread_;
  std::unique_ptr<IdleWatch> idle_;  // set by start() and stop()
};

}  // namespace weir
