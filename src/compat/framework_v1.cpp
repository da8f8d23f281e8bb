// Filter descriptors of version 1.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/open_filter.hpp"

namespace weir::compat {
namespace {

class FrameworkV1 final : public OpenFilter {
 public:
  FrameworkV1(const GstTensorFilterFramework& framework, std::unique_ptr<Properties> properties)
      : OpenFilter(std::move(properties)), framework_(framework) {
    ask_framework(nullptr);
    choose_hardware();
    if (framework_.open) {
      const int result = call("open", [&] { return framework_.open(prop(), &priv_); });
      if (result < 0) throw not_opened(name(), "open returned " + returned(result));
    }
    prop()->fw_opened = TRUE;
    ask_framework(priv_);  // an open model may give more information
  }
  ~FrameworkV1() override {
    try {
      if (framework_.close) framework_.close(prop(), &priv_);
    } catch (...) {
      nns_logw("the filter %s threw an exception in close", name().c_str());
    }
  }

  Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) override {
    const bool known = model_info(GET_IN_OUT_INFO, in, out) >= 0;
    return {known, known};
  }
  int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    return model_info(SET_INPUT_INFO, const_cast<GstTensorsInfo*>(in), out);
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    return call("invoke", [&] { return framework_.invoke(&framework_, prop(), priv_, in, out); });
  }
  bool allocates() override { return info_.allocate_in_invoke; }
  void destroy(void* data) override {
    GstTensorFilterFrameworkEventData event{};
    event.data = data;
    if (framework_.eventHandler(&framework_, prop(), priv_, DESTROY_NOTIFY, &event) < 0)
      g_free(data);
  }
  int send(event_ops op) override {
    GstTensorFilterFrameworkEventData data{};
    return call("eventHandler",
                [&] { return framework_.eventHandler(&framework_, prop(), priv_, op, &data); });
  }

 private:
  int model_info(model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
    return call("getModelInfo",
                [&] { return framework_.getModelInfo(&framework_, prop(), priv_, op, in, out); });
  }
  void ask_framework(void* priv) {
    GstTensorFilterFrameworkInfo info{};
    const int result = call("getFrameworkInfo", [&] {
      return framework_.getFrameworkInfo(&framework_, prop(), priv, &info);
    });
    if (result < 0) throw not_opened(name(), "getFrameworkInfo returned " + returned(result));
    info_ = info;
  }
  void choose_hardware() {
    const size_t count = info_.hw_list && info_.num_hw > 0 ? static_cast<size_t>(info_.num_hw) : 0;
    properties().choose_hardware({info_.hw_list, info_.hw_list + count}, info_.accl_auto,
                                 info_.accl_default, true);
  }

  const GstTensorFilterFramework& framework_;
  GstTensorFilterFrameworkInfo info_{};
  void* priv_ = nullptr;
};

}  // namespace

std::shared_ptr<OpenFilter> open_v1(const GstTensorFilterFramework& framework,
                                    std::unique_ptr<Properties> properties) {
  return std::make_shared<FrameworkV1>(framework, std::move(properties));
}

}  // namespace weir::compat
