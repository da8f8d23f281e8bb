/* Recurrent cells, custom=rnn or custom=lstm, with x of uint8 4 and states of float32 4. The first
 * output is the cell's output, the others are its next states.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <math.h>
#include <string.h>

#include "tensor_filter_custom.h"

enum { SIZE = 4 };

static int is_lstm(const GstTensorFilterProperties* prop) {
  return prop->custom_properties && strcmp(prop->custom_properties, "lstm") == 0;
}

static void* begin(const GstTensorFilterProperties* prop) {
  (void)prop;
  return NULL;
}

static void describe(GstTensorInfo* info, tensor_type type) {
  info->type = type;
  info->dimension[0] = SIZE;
}

static int inputs(void* priv, const GstTensorFilterProperties* prop, GstTensorsInfo* info) {
  unsigned i;
  (void)priv;
  info->num_tensors = is_lstm(prop) ? 3 : 2;
  describe(&info->info[0], _NNS_UINT8);
  for (i = 1; i < info->num_tensors; ++i) describe(&info->info[i], _NNS_FLOAT32);
  return 0;
}

static int outputs(void* priv, const GstTensorFilterProperties* prop, GstTensorsInfo* info) {
  unsigned i;
  (void)priv;
  info->num_tensors = is_lstm(prop) ? 3 : 2;
  for (i = 0; i < info->num_tensors; ++i) describe(&info->info[i], _NNS_FLOAT32);
  return 0;
}

static float sigmoid(float x) {
  return 1 / (1 + expf(-x));
}

static int step(void* priv, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
                GstTensorMemory* out) {
  const uint8_t* x = in[0].data;
  const float* h = in[1].data;
  float *y = out[0].data, *next = out[1].data;
  int i;
  (void)priv;
  for (i = 0; i < SIZE; ++i) {
    const float gate = 0.01f * x[i] - 0.5f * h[i];
    if (is_lstm(prop)) {
      float* cell = (float*)out[2].data + i;
      *cell = sigmoid(gate) * ((const float*)in[2].data)[i] + sigmoid(-gate) * tanhf(gate);
      next[i] = sigmoid(gate) * tanhf(*cell);
    } else {
      next[i] = tanhf(gate);
    }
    y[i] = 2 * next[i];
  }
  return 0;
}

static NNStreamer_custom_class callbacks = {
    .initfunc = begin, .getInputDim = inputs, .getOutputDim = outputs, .invoke = step};
NNStreamer_custom_class* NNStreamer_custom = &callbacks;
