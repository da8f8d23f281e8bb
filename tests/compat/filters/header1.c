/* A filter sub-plugin of version 1, `header1`, custom=:
 *   (nothing)   uint8 3 reversed, in memory that it allocates
 *   dynamic     as many values as the first value; for 7 also a second tensor of one value
 *               (invoke-dynamic=true)
 *   hardware    the result of accelerator=: int32 4
 *   properties  int32 4: latency, suspend, the rank and first layout of input 0
 *   async       one output of uint8 3 per value, the value three times (invoke-async=true)
 *   late        the same, and one more on close
 *   later:IN:OUT  invoke does nothing; a thread dispatches each byte from the pipe IN three times
 *               and then sends it through OUT
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"

static const accl_hw hardware[] = {ACCL_CPU_SIMD, ACCL_NPU, ACCL_GPU};

static int is(const GstTensorFilterProperties* prop, const char* word) {
  return prop->custom_properties && strcmp(prop->custom_properties, word) == 0;
}

static int get_model_info(const GstTensorFilterFramework* self,
                          const GstTensorFilterProperties* prop, void* priv,
                          GstTensorFilterFrameworkInfo* info) {
  (void)self;
  (void)priv;
  memset(info, 0, sizeof *info);
  info->name = "header1";
  info->run_without_model = 1;
  info->allocate_in_invoke = !prop->custom_properties;
  info->hw_list = hardware;
  info->num_hw = 3;
  info->accl_auto = ACCL_NPU;
  info->accl_default = ACCL_CPU_SIMD;
  return 0;
}

static void describe(GstTensorsInfo* info, tensor_type type, unsigned count) {
  info->num_tensors = 1;
  info->info[0].type = type;
  info->info[0].dimension[0] = count;
}

static int model(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  const int numbers = is(prop, "hardware") || is(prop, "properties");
  (void)self;
  (void)priv;
  if (op != GET_IN_OUT_INFO) return -ENOENT;
  describe(in, _NNS_UINT8, 3);
  if (is(prop, "dynamic")) return 0;
  describe(out, numbers ? _NNS_INT32 : _NNS_UINT8, numbers ? 4 : 3);
  return 0;
}

static void dispatch_three(GstTensorFilterProperties* prop, uint8_t number) {
  uint8_t three[3];
  GstTensorMemory out = {three, 3};
  memset(three, number, 3);
  nnstreamer_filter_dispatch_output_async(prop, &out);
}

static void dispatch(GstTensorFilterProperties* prop, const GstTensorMemory* in) {
  size_t i;
  for (i = 0; i < 3; ++i) dispatch_three(prop, ((const uint8_t*)in[0].data)[i]);
}

/* The thread of one element. */
struct later {
  pthread_t thread;
  int in, out;
  GstTensorFilterProperties* prop;
};

static int is_later(const GstTensorFilterProperties* prop) {
  return prop->custom_properties && strncmp(prop->custom_properties, "later:", 6) == 0;
}

static void* dispatch_later(void* data) {
  struct later* later = data;
  uint8_t number;
  while (read(later->in, &number, 1) == 1 && number != 0) {
    dispatch_three(later->prop, number);
    if (write(later->out, &number, 1) != 1) break;
  }
  return NULL;
}

static int begin(const GstTensorFilterProperties* prop, void** priv) {
  struct later* later;
  if (!is_later(prop)) return 0;
  later = calloc(1, sizeof *later);
  if (!later) return -ENOMEM;
  later->prop = (GstTensorFilterProperties*)prop;
  if (sscanf(prop->custom_properties, "later:%d:%d", &later->in, &later->out) != 2 ||
      pthread_create(&later->thread, NULL, dispatch_later, later) != 0) {
    free(later);
    return -EINVAL;
  }
  *priv = later;
  return 0;
}

static int invoke(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop, void* priv,
                  const GstTensorMemory* in, GstTensorMemory* out) {
  const uint8_t* x = in[0].data;
  int32_t* numbers = out[0].data;
  int i;
  (void)self;
  (void)priv;
  if (is_later(prop)) return 0;
  if (is(prop, "async") || is(prop, "late")) {
    dispatch(prop, in);
  } else if (is(prop, "hardware")) {
    numbers[0] = prop->num_hw;
    for (i = 0; i < 3; ++i) numbers[i + 1] = i < prop->num_hw ? (int)prop->hw_list[i] : -1;
  } else if (is(prop, "properties")) {
    numbers[0] = prop->latency;
    numbers[1] = (int)prop->suspend;
    numbers[2] = (int)prop->input_ranks[0];
    numbers[3] = prop->input_layout[0];
  } else if (is(prop, "dynamic")) {
    describe(&prop->output_meta, _NNS_UINT8, x[0]);
    out[0].size = x[0];
    out[0].data = g_malloc(x[0]);
    if (x[0] > 0) memset(out[0].data, x[0], x[0]);
    if (x[0] == 7) {
      prop->output_meta.num_tensors = 2;
      prop->output_meta.info[1] = prop->output_meta.info[0];
      prop->output_meta.info[1].dimension[0] = 1;
      out[1].size = 1;
      out[1].data = g_malloc0(1);
    }
  } else {
    out[0].data = g_malloc(3);
    for (i = 0; i < 3; ++i) ((uint8_t*)out[0].data)[i] = x[2 - i];
  }
  return 0;
}

static int event(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)self;
  (void)prop;
  (void)priv;
  if (op == CHECK_HW_AVAILABILITY && data->custom)
    return data->hw == ACCL_NPU_EDGETPU && strcmp(data->custom, "usb") == 0 ? 0 : -EINVAL;
  if (op != DESTROY_NOTIFY) return -ENOENT;
  g_free(data->data);
  return 0;
}

/* The creator of the pipe has sent a 0. */
static void end(const GstTensorFilterProperties* prop, void** priv) {
  if (is(prop, "late")) dispatch_three((GstTensorFilterProperties*)prop, 1);
  if (!*priv) return;
  pthread_join(((struct later*)*priv)->thread, NULL);
  free(*priv);
}

static GstTensorFilterFramework framework;

__attribute__((constructor)) static void add(void) {
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1 | 7;
  framework.open = begin;
  framework.close = end;
  framework.invoke = invoke;
  framework.getFrameworkInfo = get_model_info;
  framework.getModelInfo = model;
  framework.eventHandler = event;
  nnstreamer_filter_probe(&framework);
  nnstreamer_filter_set_custom_property_desc("header1", "dynamic", "as many as the first number",
                                             "hardware", "what accelerator= comes to", NULL);
}

__attribute__((destructor)) static void remove_it(void) {
  nnstreamer_filter_exit("header1");
}
