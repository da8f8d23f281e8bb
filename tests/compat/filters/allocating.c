/* A custom filter that allocates its output, uint64 2: the output's address, and how many are
 * allocated. custom= is the address of the counter of freed outputs.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdlib.h>

#include "tensor_filter_custom.h"

static long* freed;
static uint64_t made;

static void* begin(const GstTensorFilterProperties* prop) {
  freed = (long*)(uintptr_t)strtoull(prop->custom_properties, NULL, 0);
  made = 0;
  return NULL;
}

static int two_numbers(void* priv, const GstTensorFilterProperties* prop, GstTensorsInfo* info) {
  (void)priv;
  (void)prop;
  info->num_tensors = 1;
  info->info[0].type = _NNS_UINT64;
  info->info[0].dimension[0] = 2;
  return 0;
}

static int report(void* priv, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
                  GstTensorMemory* out) {
  uint64_t* y;
  (void)priv;
  (void)prop;
  if (*(const uint64_t*)in[0].data == 1) return 1;
  if (*(const uint64_t*)in[0].data == 2) return 0; /* returns no output */
  y = malloc(out[0].size);
  y[0] = (uintptr_t)y;
  y[1] = ++made;
  out[0].data = y;
  if (*(const uint64_t*)in[0].data == 3) out[0].size += 1;
  return 0;
}

static void release(void* data) {
  ++*freed;
  free(data);
}

static NNStreamer_custom_class callbacks = {.initfunc = begin,
                                            .getInputDim = two_numbers,
                                            .getOutputDim = two_numbers,
                                            .allocate_invoke = report,
                                            .destroy_notify = release};
NNStreamer_custom_class* NNStreamer_custom = &callbacks;
