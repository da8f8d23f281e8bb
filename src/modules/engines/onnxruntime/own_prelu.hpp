// PReLU of our own in the place of ONNX Runtime's, which goes number by number with a branch that
// no processor foresees: in small convolutional networks it took half of the time.
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

// The file with its PRelu named as ours, those whose slopes are a constant of the file, float32, of
// one axis or one number. Empty where there is none, and where weights lie in files beside it,
// which ONNX Runtime finds only by the file's path.
std::optional<std::vector<std::byte>> with_own_prelu(std::span<const std::byte> file);

// The operator for sessions of such files; one for the process, outlives them.
class OwnOperators {
 public:
  static Result<std::shared_ptr<const OwnOperators>> shared(
      const std::shared_ptr<const OrtRuntime>& runtime);
  OrtCustomOpDomain* domain() const noexcept { return domain_.get(); }

 private:
  OwnOperators(std::shared_ptr<const OrtRuntime> runtime, OrtCustomOpDomain* domain)
      : runtime_(std::move(runtime)), domain_(domain, runtime_->api().ReleaseCustomOpDomain) {}
  std::shared_ptr<const OrtRuntime> runtime_;  // outlives the domain
  OrtOwner<OrtCustomOpDomain> domain_;
};

}  // namespace weir::engine
