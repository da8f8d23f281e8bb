// RunningModel: the model of one tensor_filter while the element runs. It is opened, reopened when
// properties change, replaced by another file and suspended.
//
// The streaming thread reopens the model when properties change; meanwhile any thread may replace
// its file. Neither waits for the other. An opened model is installed only if no file was replaced
// meanwhile, and a replacement whose model is no longer installed is repeated on the current one.
// So in any order the newest file runs with the newest properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/timer/idle_watch.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/open_model.hpp"

namespace weir {

// The field model_files of an event evt_update_model, in the format of the property model; "" if it
// cannot be read. nullopt for any other event.
std::optional<std::string> wanted_model(GstEvent* event);

// Thread-safe, except start(), open(), close() and touch().
class RunningModel {
 public:
  using Model = std::shared_ptr<const OpenModel>;
  // Makes the monitor of the worker processes; null if there are none.
  using MakeMonitor = std::function<std::shared_ptr<isolate::Monitor>()>;
  // Rejects a model that does not fit the stream.
  using Check = std::function<Status(const OpenModel&)>;
  // Replaces the model by the one of that name and reports the result. Must not throw.
  using Replace = std::function<void(const std::string& model)>;

  ~RunningModel() { close(); }
  // Reverts stop().
  void start();
  // Calls that wait for a worker process, now or later, return CANCELLED.
  void stop();
  // Waits for a running replacement. Afterwards nothing is replaced or suspended.
  void close() noexcept;
  bool stopped() const;

  // Opens a model with `settings`, installs it and suspends it when no frames arrive. If another
  // one is installed, its file is used instead of the one in `settings`.
  Status open(FilterSettings* settings, const MakeMonitor& make_monitor, const Check& check,
              std::vector<Error>* warnings);
  // Replaces the file of the installed model, if there is one. `settings` returns the newest
  // properties with the new file; it is called once for each attempt.
  Status replace(const std::function<FilterSettings()>& settings);
  // Calls `replace` on a thread of its own. Of several requests that arrive meanwhile, only the
  // newest is kept.
  void replace_later(std::string model, Replace replace);
  // Call when a frame arrives and when it was processed.
  void touch() {
    if (idle_) idle_->touch();
  }

  Model get() const;
  std::shared_ptr<isolate::Monitor> monitor() const;
  std::string file() const;  // of the installed model: the value of the property `model`

 private:
  uint64_t begin(std::shared_ptr<isolate::Monitor> monitor, FilterSettings* settings);
  Status install(FilterSettings* settings, const MakeMonitor& make_monitor, const Check& check,
                 std::vector<Error>* warnings);
  void replace_all();

  mutable std::mutex mutex_;  // guards the rest except idle_
  Model model_;
  std::string file_;
  uint64_t replacements_ = 0;  // number of replaced files
  std::shared_ptr<isolate::Monitor> monitor_,
      next_monitor_;  // of model_; of the model that is being opened
  bool stopped_ = false;
  bool replaces_ = false;              // replace_later() has an effect
  std::optional<std::string> wanted_;  // the next file of replace_later()
  Replace replace_;
  bool replacing_ = false;  // thread_ runs
  std::thread thread_;
  std::unique_ptr<IdleWatch> idle_;  // set by open() and close()
};

}  // namespace weir
