/* A custom filter that calls the library: converts channels:width:height of uint8 to the mean of
 * each channel, float32.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <errno.h>

#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_custom.h"

static void* begin(const GstTensorFilterProperties* prop) {
  nns_logi("average of %s", prop->model_files[0]);
  return NULL;
}

static int means(void* priv, const GstTensorFilterProperties* prop, const GstTensorsInfo* in,
                 GstTensorsInfo* out) {
  GstTensorInfo* mean;
  (void)priv;
  (void)prop;
  if (in->num_tensors != 1 || in->info[0].type != _NNS_UINT8) return -EINVAL;
  gst_tensors_info_init(out);
  out->num_tensors = 1;
  mean = gst_tensors_info_get_nth_info(out, 0);
  mean->type = gst_tensor_get_type("float32");
  gst_tensor_parse_dimension("1:1:1", mean->dimension);
  mean->dimension[0] = in->info[0].dimension[0];
  return 0;
}

static int average(void* priv, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
                   GstTensorMemory* out) {
  const size_t channels = prop->input_meta.info[0].dimension[0];
  const size_t pixels = gst_tensors_info_get_size(&prop->input_meta, 0) / channels;
  size_t c, i;
  (void)priv;
  for (c = 0; c < channels; ++c) {
    double sum = 0;
    for (i = 0; i < pixels; ++i) sum += ((const uint8_t*)in[0].data)[i * channels + c];
    ((float*)out[0].data)[c] = (float)(sum / (double)pixels);
  }
  return 0;
}

static NNStreamer_custom_class callbacks = {
    .initfunc = begin, .setInputDim = means, .invoke = average};
NNStreamer_custom_class* NNStreamer_custom = &callbacks;
