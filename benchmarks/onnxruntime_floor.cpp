// ONNX Runtime in a plain loop. WEIR_ENGINE_LIBRARY: the library that the module loads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bare_loop.hpp"
#include "engine_floor.hpp"

namespace weir::bench {
namespace {

class OnnxruntimeFloor : public EngineFloor {
 public:
  explicit OnnxruntimeFloor(const std::string& model)
      : loop_(WEIR_ENGINE_LIBRARY, model.c_str(), 1) {}
  void run(int frames) override { loop_.run(frames); }

 private:
  BareLoop loop_;
};

}  // namespace

std::unique_ptr<EngineFloor> make_floor(const std::string& models, const std::vector<int64_t>&,
                                        bool) {
  return std::make_unique<OnnxruntimeFloor>(models);
}

}  // namespace weir::bench
