// Descriptions of tensors between Weir's engines and C structs; what callbacks said is checked.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "compat/spec.hpp"
#include "weir/abi.h"
#include "weir/module.hpp"

namespace weir::compat {

// Owns a GstTensorsInfo. Names that a callback puts in stay the callback's: whose they are is not
// known, and they are copied.
class TensorsInfo {
 public:
  TensorsInfo() noexcept;
  ~TensorsInfo();
  TensorsInfo(const TensorsInfo&) = delete;
  TensorsInfo& operator=(const TensorsInfo&) = delete;

  GstTensorsInfo* get() noexcept { return &info_; }
  const GstTensorsInfo& operator*() const noexcept { return info_; }
  void assign(std::span<const weir_tensor_info> tensors);

 private:
  GstTensorsInfo info_;
};

// `to` has this as its tensors; its names and `extra` are owned and freed by clear(). What is not
// known is _NNS_END or without dimensions.
void assign(std::span<const weir_tensor_info> tensors, GstTensorsInfo* to);

// Descriptions for an engine, and what keeps their names.
struct Described {
  std::vector<weir_tensor_info> infos;
  std::deque<std::string> names;
};

// What `filter` said of its inputs or outputs (`role`: "input" or "output"). Throws CALLBACK_FAILED
// for what cannot be: no or more than 256 tensors, a type out of range, dimensions that are none,
// 4 GiB and more.
Described described(const GstTensorsInfo& info, const std::string& filter, const char* role);

// As many tensors of which nothing is known.
Described open_tensors(size_t count);

}  // namespace weir::compat
