// A filter sub-plugin as a class, `classes`: float32 2 plus the number in custom=. custom=throw
// throws on opening, custom=device throws a system error code; a first value of 13 throws, too.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "nnstreamer_cppplugin_api_filter.hh"

namespace {

class Adder : public nnstreamer::tensor_filter_subplugin {
 public:
  tensor_filter_subplugin& getEmptyInstance() override { return *new Adder; }
  void configure_instance(const GstTensorFilterProperties* prop) override {
    const std::string custom = prop->custom_properties ? prop->custom_properties : "0";
    if (custom == "throw") throw std::invalid_argument("no number");
    if (custom == "device")
      throw std::system_error(std::make_error_code(std::errc::no_such_device));
    number_ = std::stof(custom);
  }
  void invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    const auto* x = static_cast<const float*>(in[0].data);
    if (x[0] == 13) throw std::runtime_error("unlucky");
    for (int i = 0; i < 2; ++i) static_cast<float*>(out[0].data)[i] = x[i] + number_;
  }
  void getFrameworkInfo(GstTensorFilterFrameworkInfo& info) override {
    info.name = "classes";
    info.run_without_model = 1;
  }
  int getModelInfo(model_info_ops op, GstTensorsInfo& in, GstTensorsInfo& out) override {
    if (op != GET_IN_OUT_INFO) return -ENOENT;
    for (auto* info : {&in, &out}) {
      info->num_tensors = 1;
      info->info[0].type = _NNS_FLOAT32;
      info->info[0].dimension[0] = 2;
    }
    return 0;
  }
  int eventHandler(event_ops op, GstTensorFilterFrameworkEventData&) override {
    return op == SUSPEND || op == RESUME ? 0 : -ENOENT;
  }

 private:
  float number_ = 0;
};

Adder* registered;

__attribute__((constructor)) void begin() {
  registered = nnstreamer::tensor_filter_subplugin::register_subplugin<Adder>();
}
__attribute__((destructor)) void end() {
  nnstreamer::tensor_filter_subplugin::unregister_subplugin(registered);
}

}  // namespace
