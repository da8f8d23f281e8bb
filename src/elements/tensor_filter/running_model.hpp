// RunningModel: holds the model of one tensor_filter and decides which model replaces it.
//
// The streaming thread reopens the model when properties change; meanwhile any thread may replace
// its file. Neither waits for the other. An opened model is installed only if no file was replaced
// meanwhile, and a replacement whose model is no longer installed is repeated on the current one.
// So in any order the newest file runs with the newest properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/open_model.hpp"

namespace weir {

// Thread-safe.
class RunningModel {
 public:
  using Model = std::shared_ptr<const OpenModel>;
  // Makes the monitor of the worker processes; null if there are none.
  using MakeMonitor = std::function<std::shared_ptr<isolate::Monitor>()>;
  // Rejects a model that does not fit the stream.
  using Check = std::function<Status(const OpenModel&)>;

  // Reverts stop().
  void start();
  // Calls that wait for a worker process, now or later, return CANCELLED.
  void stop();
  void close();
  bool stopped() const;

  // Opens a model with `settings` and installs it. If another one is installed, its file is used
  // instead of the one in `settings`.
  Status open(FilterSettings* settings, const MakeMonitor& make_monitor, const Check& check,
              std::vector<Error>* warnings);
  // Replaces the file of the installed model, if there is one. `settings` returns the newest
  // properties with the new file; it is called once for each attempt.
  Status replace(const std::function<FilterSettings()>& settings);

  Model get() const;
  std::shared_ptr<isolate::Monitor> monitor() const;
  std::string file() const;  // of the installed model: the value of the property `model`

 private:
  uint64_t begin(std::shared_ptr<isolate::Monitor> monitor, FilterSettings* settings);

  mutable std::mutex mutex_;  // guards the rest
  Model model_;
  std::string file_;
  uint64_t replacements_ = 0;  // number of replaced files
  std::shared_ptr<isolate::Monitor> monitor_,
      next_monitor_;  // of model_; of the model that is being opened
  bool stopped_ = false;
};

}  // namespace weir
