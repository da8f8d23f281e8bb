// Helpers of tests of pipelines: made from their text, or the test fails.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <stdexcept>
#include <string>

#include "weir/pipeline.hpp"

namespace weir::pipeline_test {

inline constexpr std::chrono::seconds kLong{60};  // never reached when the test passes

inline Pipeline parse(const std::string& text) {
  auto pipeline = Pipeline::parse(text);
  if (!pipeline) throw std::runtime_error(pipeline.error().message());
  return *std::move(pipeline);
}
inline Pipeline started(const std::string& text) {
  Pipeline pipeline = parse(text);
  if (const auto status = pipeline.start(); !status)
    throw std::runtime_error(status.error().message());
  return pipeline;
}

}  // namespace weir::pipeline_test
