// Replaces ONNX Runtime's PReLU, which processes single elements with an unpredictable branch: in
// small convolutional networks it took half of the time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "onnxruntime/ort_api.hpp"

namespace weir::engine {

// Returns the file with those PRelu nodes renamed to our operator whose slopes are a float32
// constant of the file with one axis or one element. Empty when there are none, or when weights are
// in separate files, which ONNX Runtime finds only by the file's path.
std::optional<std::vector<std::byte>> with_own_prelu(std::span<const std::byte> file);

// Registers the operator for sessions of such files; one per process, outlives the sessions.
class OwnOperators {
 public:
  static Result<std::shared_ptr<const OwnOperators>> shared(
      const std::shared_ptr<const OrtRuntime>& runtime);
  OrtCustomOpDomain* domain() const noexcept { return domain_.get(); }

 private:
  OwnOperators(std::shared_ptr<const OrtRuntime> runtime, OrtCustomOpDomain* domain)
      : runtime_(std::move(runtime)), domain_(domain, runtime_->api().ReleaseCustomOpDomain) {}
  std::shared_ptr<const OrtRuntime> runtime_;  // must outlive the domain
  OrtOwner<OrtCustomOpDomain> domain_;
};

}  // namespace weir::engine
