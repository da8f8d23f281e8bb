// Filters that the application registered (weir/custom_filter.h), and the engine custom-easy that
// runs them (docs/compatibility/filter.md 4.11).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/infer/queue/call_gate.hpp"
#include "weir/abi.h"
#include "weir/custom_filter.h"
#include "weir/result.hpp"

namespace weir::custom {

// A copy of the registered filter; releases its data.
class NamedFilter {
 public:
  // OPTION_VALUE for an invalid description. `data` is not released before own().
  static Result<std::shared_ptr<NamedFilter>> make(const std::string& name,
                                                   const weir_filter& filter);
  ~NamedFilter();
  NamedFilter(const NamedFilter&) = delete;
  NamedFilter& operator=(const NamedFilter&) = delete;

  // Takes ownership of the data.
  void own(void (*release)(void*)) noexcept { release_ = release; }
  // Call it when the name is released. Without `release` the program may free the data afterwards:
  // waits for running calls, and later ones fail.
  void unregistered() {
    if (!release_) gate_.close();
  }

  const std::string& name() const noexcept { return name_; }
  uint32_t flags() const noexcept { return filter_.flags; }  // weir_filter_flag
  std::span<const weir_tensor_info> inputs() const noexcept { return inputs_; }
  std::span<const weir_tensor_info> outputs() const noexcept { return outputs_; }
  // Calls the filter's functions; errors begin with the filter's name. invoke returns true if the
  // frame is filled, false if it is dropped.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  Result<bool> invoke(const weir_frame& in, weir_frame& out);

 private:
  NamedFilter(std::string name, const weir_filter& filter);
  std::vector<weir_tensor_info> copy(const weir_tensor_info* infos, uint32_t count);
  std::unique_lock<std::mutex> take_turn();
  // CALLBACK_UNKNOWN: see unregistered().
  template <class Body>
  Result<int> call(Body&& body);
  Error failed(int result, weir_error* error) const;

  std::string name_;
  weir_filter filter_;
  void (*release_)(void*) = nullptr;
  std::deque<std::string> names_;  // of tensors
  std::vector<weir_tensor_info> inputs_, outputs_;
  infer::CallGate gate_;
  std::mutex turn_;  // taken before the gate; held while a function that is not thread-safe runs
};

// Finds a registered filter, or one that a library of its name registers when it is loaded
// (filter_library.hpp). CALLBACK_UNKNOWN with the registered names.
Result<std::shared_ptr<NamedFilter>> find_filter(const std::string& name);

const weir_engine& custom_easy_engine();

// Filters of the application declare whether they need invoke-dynamic; OPTION_VALUE if the user's
// setting differs. Models of other engines work with both.
Status check_invocation(const weir_engine& engine, const weir_model_info& info,
                        const std::string& model, bool invoke_dynamic);

}  // namespace weir::custom
