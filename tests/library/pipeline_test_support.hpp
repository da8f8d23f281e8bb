// Helpers of tests of pipelines: made from their text, or the test fails.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

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

// The first tensor of the next frame at a sink; empty at the end of the stream.
inline std::vector<float> pulled(Pipeline& pipeline, const std::string& name) {
  const auto frame = pipeline.pull<float>(name, kLong);
  if (!frame) throw std::runtime_error(frame.error().message());
  if (!*frame) return {};
  const auto all = *(**frame)[0].as<float>();
  return {all.begin(), all.end()};
}

}  // namespace weir::pipeline_test
