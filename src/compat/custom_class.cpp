// Calls the callbacks of a shared object that exports NNStreamer_custom.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/open_filter.hpp"

namespace weir::compat {
namespace {

Failure refused(const std::string& file, const char* offered, const char* needed, const char* fix) {
  return Failure({.code = Code::MODULE_REFUSED,
                  .what = "the custom filter " + file + " cannot be used",
                  .offered = offered,
                  .needed = needed,
                  .fix = fix});
}

void check(const NNStreamer_custom_class& callbacks, const std::string& file) {
  const bool gets = callbacks.getInputDim || callbacks.getOutputDim;
  if (!callbacks.initfunc)
    throw refused(
        file, "no initfunc", "initfunc, which initializes the filter",
        "set .initfunc to a function that returns the private data of the filter, or NULL");
  if (gets && callbacks.setInputDim)
    throw refused(file, "setInputDim together with getInputDim or getOutputDim",
                  "either getInputDim and getOutputDim, or setInputDim",
                  "remove setInputDim if the tensor sizes are fixed; otherwise remove the other "
                  "two functions");
  if (!callbacks.setInputDim && !(callbacks.getInputDim && callbacks.getOutputDim))
    throw refused(
        file,
        gets ? "only one of getInputDim and getOutputDim" : "no function that declares the tensors",
        "getInputDim and getOutputDim, or setInputDim", ".getInputDim = ..., .getOutputDim = ...");
  if (callbacks.invoke && callbacks.allocate_invoke)
    throw refused(file, "both invoke and allocate_invoke", "only one of them",
                  "remove the function that the filter does not use");
  if (!callbacks.invoke && !callbacks.allocate_invoke)
    throw refused(file, "no invoke", "invoke or allocate_invoke", ".invoke = ...");
}

class CustomClass final : public OpenFilter {
 public:
  CustomClass(const NNStreamer_custom_class& callbacks, std::unique_ptr<Properties> properties)
      : OpenFilter(std::move(properties)), callbacks_(callbacks) {
    check(callbacks_, name());
    properties_chosen();
    priv_ = call("initfunc", [&] { return callbacks_.initfunc(prop()); });
    prop()->fw_opened = TRUE;
  }
  ~CustomClass() override {
    try {
      if (callbacks_.exitfunc) callbacks_.exitfunc(priv_, prop());
    } catch (...) {
      nns_logw("the filter %s threw an exception in exitfunc", name().c_str());
    }
  }

  Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) override {
    if (callbacks_.setInputDim) return {false, false};
    const int inputs =
        call("getInputDim", [&] { return callbacks_.getInputDim(priv_, prop(), in); });
    const int outputs =
        call("getOutputDim", [&] { return callbacks_.getOutputDim(priv_, prop(), out); });
    if (inputs < 0 || outputs < 0)
      throw not_opened(name(), std::string(inputs < 0 ? "getInputDim" : "getOutputDim") +
                                   " returned " + returned(inputs < 0 ? inputs : outputs));
    return {true, true};
  }
  int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    if (!callbacks_.setInputDim) return -ENOENT;
    return call("setInputDim", [&] { return callbacks_.setInputDim(priv_, prop(), in, out); });
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    if (callbacks_.allocate_invoke)
      return call("allocate_invoke",
                  [&] { return callbacks_.allocate_invoke(priv_, prop(), in, out); });
    return call("invoke", [&] { return callbacks_.invoke(priv_, prop(), in, out); });
  }
  bool allocates() override { return callbacks_.allocate_invoke; }
  void destroy(void* data) override {
    if (callbacks_.destroy_notify)
      callbacks_.destroy_notify(data);
    else
      g_free(data);
  }

 private:
  void properties_chosen() { properties().choose_hardware({}, ACCL_AUTO, ACCL_DEFAULT, false); }

  const NNStreamer_custom_class callbacks_;
  void* priv_ = nullptr;
};

}  // namespace

std::shared_ptr<OpenFilter> open_class(const NNStreamer_custom_class& callbacks,
                                       std::unique_ptr<Properties> properties) {
  return std::make_shared<CustomClass>(callbacks, std::move(properties));
}

}  // namespace weir::compat
