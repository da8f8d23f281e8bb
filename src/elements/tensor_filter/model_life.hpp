// ModelLife: what happens to the model of one tensor_filter while frames flow: another takes its
// place, it is put to sleep, it is opened again.
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
#include "elements/tensor_filter/opened_model.hpp"

namespace weir {

// The value of the field model_files of an event evt_update_model, as the property model has it; ""
// when there is none that can be read. nullopt: it is another event.
std::optional<std::string> wanted_model(GstEvent* event);

// Thread-safe, but for start() and stop().
class ModelLife {
 public:
  // Calls the function, which replaces the model, and tells the user what came of it. Throws
  // nothing.
  using Done = std::function<void(const std::function<Status()>&, const std::string& model)>;

  ~ModelLife() { stop(); }
  // `model` runs now, with these settings.
  void start(std::shared_ptr<const OpenedModel> model, const FilterSettings& settings);
  // Waits for a replacement that goes on. Nothing is replaced or put to sleep then.
  void stop() noexcept;

  // Puts `model` in place of the one that runs, on this thread; what runs stays on an error.
  Status replace(FilterSettings settings) const;
  // The same on a thread of its own. While one is opened the newest wish waits, those between are
  // forgotten.
  void replace_later(FilterSettings settings, Done done);

  // A frame comes or has gone.
  void touch() {
    if (idle_) idle_->touch();
  }

 private:
  void replace_all();

  mutable std::mutex mutex_;  // guards the rest, but idle_
  std::shared_ptr<const OpenedModel> model_;
  std::optional<FilterSettings> wanted_;
  Done done_;
  bool replacing_ = false;
  std::thread thread_;
  std::unique_ptr<IdleWatch> idle_;  // set by start() and stop()
};

}  // namespace weir
