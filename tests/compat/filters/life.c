/* A filter sub-plugin that adds the number in its model's file to as many float32 as the second
 * number there (default 4), and reports its lifecycle to the pipe custom=FD: o(pen), c(lose),
 * s(uspend), r(esume), R(eload). With +FD it supports suspend and resume. `life` is of version 0;
 * with VERSION=1 it is `life1`, of version 1.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "nnstreamer_plugin_api_filter.h"

struct model {
  float number;
  unsigned count;
};

static int pipe_end, sleeps;

static void report(char what) {
  if (write(pipe_end, &what, 1) != 1) abort();
}

static int begin(const GstTensorFilterProperties* prop, void** priv) {
  FILE* file = fopen(prop->model_files[0], "r");
  struct model* model = malloc(sizeof *model);
  int read = 0;
  if (file && model) read = fscanf(file, "%f %u", &model->number, &model->count);
  if (file) fclose(file);
  if (read < 1) {
    free(model);
    return -EIO;
  }
  if (read < 2) model->count = 4;
  sleeps = prop->custom_properties[0] == '+';
  pipe_end = atoi(prop->custom_properties);
  report('o');
  *priv = model;
  return 0;
}

static void end(const GstTensorFilterProperties* prop, void** priv) {
  (void)prop;
  report('c');
  free(*priv);
}

static void describe(const struct model* model, GstTensorsInfo* info) {
  info->num_tensors = 1;
  info->info[0].type = _NNS_FLOAT32;
  info->info[0].dimension[0] = model->count;
}

static int add(const struct model* model, const GstTensorMemory* in, GstTensorMemory* out) {
  unsigned i;
  for (i = 0; i < model->count; ++i)
    ((float*)out[0].data)[i] = ((const float*)in[0].data)[i] + model->number;
  return 0;
}

static int handle_event(event_ops op) {
  if (op == RELOAD_MODEL) report('R');
  if (!sleeps || (op != SUSPEND && op != RESUME)) return -ENOENT;
  report(op == SUSPEND ? 's' : 'r');
  return 0;
}

static GstTensorFilterFramework framework = {.open = begin, .close = end};

#if VERSION == 1
static int about(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, GstTensorFilterFrameworkInfo* info) {
  (void)self;
  (void)prop;
  (void)priv;
  info->name = "life1";
  info->verify_model_path = 1;
  return 0;
}
static int tensors(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                   void* priv, model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  (void)self;
  (void)prop;
  if (op != GET_IN_OUT_INFO) return -ENOENT;
  describe(priv, in);
  describe(priv, out);
  return 0;
}
static int invoke(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop, void* priv,
                  const GstTensorMemory* in, GstTensorMemory* out) {
  (void)self;
  (void)prop;
  return add(priv, in, out);
}
static int event(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)self;
  (void)prop;
  (void)priv;
  (void)data;
  return handle_event(op);
}

__attribute__((constructor)) static void begin_all(void) {
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
  framework.invoke = invoke;
  framework.getFrameworkInfo = about;
  framework.getModelInfo = tensors;
  framework.eventHandler = event;
  nnstreamer_filter_probe(&framework);
}
#else
static int tensors(const GstTensorFilterProperties* prop, void** priv, GstTensorsInfo* info) {
  (void)prop;
  describe(*priv, info);
  return 0;
}
static int invoke(const GstTensorFilterProperties* prop, void** priv, const GstTensorMemory* in,
                  GstTensorMemory* out) {
  (void)prop;
  return add(*priv, in, out);
}
static int reload(const GstTensorFilterProperties* prop, void** priv) {
  (void)prop;
  (void)priv;
  report('R');
  return 0;
}
static int event(event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)data;
  return handle_event(op);
}

__attribute__((constructor)) static void begin_all(void) {
  static char name[] = "life";
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V0;
  framework.name = name;
  framework.verify_model_path = 1;
  framework.invoke_NN = invoke;
  framework.getInputDimension = tensors;
  framework.getOutputDimension = tensors;
  framework.reloadModel = reload;
  framework.handleEvent = event;
  nnstreamer_filter_probe(&framework);
}
#endif
