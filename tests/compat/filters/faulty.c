/* Filter sub-plugins, each with one fault (FAULT of the build): libnnstreamer_filter_faultyN.so. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stddef.h>

#include "nnstreamer_plugin_api_filter.h"

static int invoke(const GstTensorFilterProperties* prop, void** priv, const GstTensorMemory* in,
                  GstTensorMemory* out) {
  (void)prop;
  (void)priv;
  (void)in;
  (void)out;
  return 0;
}
static int set(const GstTensorFilterProperties* prop, void** priv, const GstTensorsInfo* in,
               GstTensorsInfo* out) {
  (void)prop;
  (void)priv;
  (void)in;
  (void)out;
  return 0;
}
static int get(const GstTensorFilterProperties* prop, void** priv, GstTensorsInfo* info) {
  (void)prop;
  (void)priv;
  (void)info;
  return 0;
}
static int invoke1(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop,
                   void* priv, const GstTensorMemory* in, GstTensorMemory* out) {
  (void)self;
  (void)prop;
  (void)priv;
  (void)in;
  (void)out;
  return 0;
}
static int fails(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, GstTensorFilterFrameworkInfo* info) {
  (void)self;
  (void)prop;
  (void)priv;
  (void)info;
  return -5;
}
static int nameless(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                    void* priv, GstTensorFilterFrameworkInfo* info) {
  (void)self;
  (void)prop;
  (void)priv;
  info->name = NULL;
  return 0;
}
static int model(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  (void)self;
  (void)prop;
  (void)priv;
  (void)op;
  (void)in;
  (void)out;
  return 0;
}
static int event(const GstTensorFilterFramework* self, const GstTensorFilterProperties* prop,
                 void* priv, event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)self;
  (void)prop;
  (void)priv;
  (void)op;
  (void)data;
  return 0;
}

static GstTensorFilterFramework framework;

__attribute__((constructor)) static void add(void) {
  static char name[] = "faulty0", any[] = "ANY", taken[] = "hand0";
  name[6] = '0' + FAULT;
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V0;
  framework.name = name;
  framework.invoke_NN = invoke;
  framework.setInputDimension = set;
  if (FAULT == 0) framework.version = 0xDEAFDEAD00020000;
  if (FAULT == 1) framework.version = 1;
  if (FAULT == 2) framework.name = NULL;
  if (FAULT == 3) framework.name = any;
  if (FAULT == 4) framework.name = taken;
  if (FAULT == 5) framework.invoke_NN = NULL;
  if (FAULT == 6) framework.setInputDimension = NULL;
  if (FAULT == 7) framework.setInputDimension = NULL, framework.getInputDimension = get;
  if (FAULT == 8) {
    framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
    framework.invoke = invoke1;
    framework.getFrameworkInfo = fails;
    framework.getModelInfo = model;
    framework.eventHandler = event;
  }
  if (FAULT == 9) {
    framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
    framework.invoke = invoke1;
    framework.getFrameworkInfo = nameless;
    framework.getModelInfo = model;
    framework.eventHandler = NULL;
  }
  nnstreamer_filter_probe(&framework);
}
