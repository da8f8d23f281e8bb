// Filter descriptors of version 0.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/open_filter.hpp"

namespace weir::compat {
namespace {

class FrameworkV0 final : public OpenFilter {
 public:
  FrameworkV0(const GstTensorFilterFramework& framework, std::unique_ptr<Properties> properties)
      : OpenFilter(std::move(properties)), framework_(framework) {
    choose_hardware();
    if (!framework_.open) return;
    const int result = call("open", [&] { return framework_.open(prop(), &priv_); });
    if (result < 0) throw not_opened(name(), "open returned " + returned(result));
    prop()->fw_opened = TRUE;
  }
  ~FrameworkV0() override {
    try {
      if (framework_.close) framework_.close(prop(), &priv_);
    } catch (...) {
      nns_logw("the filter %s threw an exception in close", name().c_str());
    }
  }

  Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) override {
    if (!framework_.getInputDimension || !framework_.getOutputDimension) return {false, false};
    const int inputs =
        call("getInputDimension", [&] { return framework_.getInputDimension(prop(), &priv_, in); });
    const int outputs = call("getOutputDimension",
                             [&] { return framework_.getOutputDimension(prop(), &priv_, out); });
    return {inputs >= 0, outputs >= 0};
  }
  int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    if (!framework_.setInputDimension) return -ENOENT;
    return call("setInputDimension",
                [&] { return framework_.setInputDimension(prop(), &priv_, in, out); });
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    return call("invoke_NN", [&] { return framework_.invoke_NN(prop(), &priv_, in, out); });
  }
  bool allocates() override {
    if (!framework_.allocate_in_invoke) return false;
    return !framework_.allocateInInvoke ||
           call("allocateInInvoke", [&] { return framework_.allocateInInvoke(&priv_); }) == 0;
  }
  void destroy(void* data) override {
    if (framework_.destroyNotify)
      framework_.destroyNotify(&priv_, data);
    else
      g_free(data);
  }
  int send(event_ops op) override {
    if (!framework_.handleEvent) return -ENOENT;
    GstTensorFilterFrameworkEventData data{};
    return call("handleEvent", [&] { return framework_.handleEvent(op, &data); });
  }

 private:
  // The framework has no list of accelerators: its availability function is queried for each.
  void choose_hardware() {
    std::vector<accl_hw> supported;
    if (framework_.checkAvailability)
      for (const auto hw :
           {ACCL_CPU, ACCL_CPU_SIMD, ACCL_GPU, ACCL_NPU, ACCL_NPU_MOVIDIUS, ACCL_NPU_EDGETPU,
            ACCL_NPU_VIVANTE, ACCL_NPU_SRCN, ACCL_NPU_SLSI, ACCL_NPU_SR})
        if (call("checkAvailability", [&] { return framework_.checkAvailability(hw); }) == 0)
          supported.push_back(hw);
    properties().choose_hardware(supported, ACCL_AUTO, ACCL_DEFAULT, false);
  }

  const GstTensorFilterFramework& framework_;
  void* priv_ = nullptr;
};

}  // namespace

std::shared_ptr<OpenFilter> open_v0(const GstTensorFilterFramework& framework,
                                    std::unique_ptr<Properties> properties) {
  return std::make_shared<FrameworkV0>(framework, std::move(properties));
}

}  // namespace weir::compat
