/* Whether a framework runs on hardware: sub-plugins of both versions are asked, through the
 * function of the core and through the application API.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "nnstreamer_plugin_api_filter.h"
/* After the header of the core. */
#include "nnstreamer.h"

static int failed_checks;

#define CHECK(condition)                                               \
  do {                                                                 \
    if (!(condition)) {                                                \
      printf("%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      ++failed_checks;                                                 \
    }                                                                  \
  } while (0)

static int open_model(const GstTensorFilterProperties* prop, void** priv) {
  (void)prop, (void)priv;
  return 0;
}

static void close_model(const GstTensorFilterProperties* prop, void** priv) {
  (void)prop, (void)priv;
}

static int invoke0(const GstTensorFilterProperties* prop, void** priv, const GstTensorMemory* in,
                   GstTensorMemory* out) {
  (void)prop, (void)priv, (void)in, (void)out;
  return 0;
}

static int dimension0(const GstTensorFilterProperties* prop, void** priv, GstTensorsInfo* info) {
  (void)prop, (void)priv, (void)info;
  return -EINVAL;
}

static int only_the_gpu(accl_hw hw) {
  return hw == ACCL_GPU ? 0 : -ENOENT;
}

static int invoke1(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop,
                   void* priv, const GstTensorMemory* in, GstTensorMemory* out) {
  (void)self, (void)prop, (void)priv, (void)in, (void)out;
  return 0;
}

static int framework_info1(const GstTensorFilterFramework* self,
                           const GstTensorFilterProperties* prop, void* priv,
                           GstTensorFilterFrameworkInfo* info) {
  static const accl_hw hardware[] = {ACCL_NPU_SLSI};
  (void)self, (void)prop, (void)priv;
  info->name = "snpe";
  info->hw_list = hardware;
  info->num_hw = 1;
  return 0;
}

static int model_info1(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                       void* priv, model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  (void)self, (void)prop, (void)priv, (void)op, (void)in, (void)out;
  return -EINVAL;
}

/* With a custom string, the event decides. */
static int event1(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                  void* priv, event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)self, (void)prop, (void)priv;
  if (op != CHECK_HW_AVAILABILITY || !data->custom) return -ENOENT;
  return strcmp(data->custom, "here") == 0 && data->hw == ACCL_NPU_SLSI ? 0 : -EINVAL;
}

static bool is_available(ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw, const char* custom) {
  bool available = false;
  CHECK(ml_check_nnfw_availability_full(nnfw, hw, custom, &available) == ML_ERROR_NONE);
  return available;
}

int main(void) {
  static GstTensorFilterFramework version0, version1;
  version0.version = GST_TENSOR_FILTER_FRAMEWORK_V0;
  version0.open = version1.open = open_model;
  version0.close = version1.close = close_model;
  version0.name = (char*)"vivante";
  version0.invoke_NN = invoke0;
  version0.getInputDimension = version0.getOutputDimension = dimension0;
  version0.checkAvailability = only_the_gpu;
  version1.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
  version1.invoke = invoke1;
  version1.getFrameworkInfo = framework_info1;
  version1.getModelInfo = model_info1;
  version1.eventHandler = event1;
  CHECK(!is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_ANY, NULL));
  CHECK(nnstreamer_filter_probe(&version0));
  CHECK(nnstreamer_filter_probe(&version1));

  CHECK(is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_ANY, NULL));
  CHECK(is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_AUTO, NULL));
  CHECK(is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_GPU, NULL));
  CHECK(!is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_CPU, NULL));
  CHECK(is_available(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_NPU_SLSI, NULL));
  CHECK(is_available(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_NPU_SLSI, "here"));
  CHECK(!is_available(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_NPU_SLSI, "elsewhere"));
  CHECK(!is_available(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_CPU, NULL));

  CHECK(gst_tensor_filter_check_hw_availability("vivante", ACCL_DEFAULT, NULL));
  CHECK(gst_tensor_filter_check_hw_availability("vivante", ACCL_GPU, NULL));
  CHECK(!gst_tensor_filter_check_hw_availability("vivante", ACCL_CPU, NULL));
  CHECK(!gst_tensor_filter_check_hw_availability("snpe", ACCL_NPU_SLSI, "elsewhere"));
  nnstreamer_filter_exit("vivante");
  nnstreamer_filter_exit("snpe");
  CHECK(!is_available(ML_NNFW_TYPE_VIVANTE, ML_NNFW_HW_ANY, NULL));
  return failed_checks > 0;
}
