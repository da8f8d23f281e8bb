// libtorch in a plain loop, with the model frozen and optimised as in the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <c10/core/InferenceMode.h>
#include <dlfcn.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/serialization/import.h>

#include "engine_floor.hpp"

namespace weir::bench {
namespace {

class TorchFloor : public EngineFloor {
 public:
  TorchFloor(const std::string& model, const std::vector<int64_t>& shape, bool uint8)
      : input_(at::zeros(shape, uint8 ? at::kByte : at::kFloat)) {
    void* blas = dlopen("libblas.so.3", RTLD_LAZY | RTLD_NOLOAD);
    const auto set =
        reinterpret_cast<void (*)(int)>(blas ? dlsym(blas, "openblas_set_num_threads") : nullptr);
    if (set) set(1);
    module_ = torch::jit::load(model, at::kCPU);
    module_.eval();
    module_ = torch::jit::optimize_for_inference(module_ = torch::jit::freeze(module_));
  }
  void run(int frames) override {
    at::set_num_threads(1);  // applies to the calling thread
    const c10::InferenceMode inference;
    const auto forward = module_.get_method("forward");
    for (int i = 0; i < frames; ++i) (void)forward({input_});
  }

 private:
  at::Tensor input_;
  torch::jit::Module module_;
};

}  // namespace

std::unique_ptr<EngineFloor> make_floor(const std::string& models,
                                        const std::vector<int64_t>& shape, bool uint8) {
  return std::make_unique<TorchFloor>(models, shape, uint8);
}

}  // namespace weir::bench
