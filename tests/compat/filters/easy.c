/* A library that registers a filter for framework=custom-easy when it is loaded. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <string.h>

#include "tensor_filter_custom_easy.h"

static int add_one(void* data, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
                   GstTensorMemory* out) {
  size_t i;
  (void)data;
  (void)prop;
  for (i = 0; i < in[0].size; ++i)
    ((uint8_t*)out[0].data)[i] = (uint8_t)(((const uint8_t*)in[0].data)[i] + 1);
  return 0;
}

__attribute__((constructor)) static void add(void) {
  GstTensorsInfo info;
  memset(&info, 0, sizeof info);
  info.num_tensors = 1;
  info.info[0].type = _NNS_UINT8;
  info.info[0].dimension[0] = 2;
  NNS_custom_easy_register("easy", add_one, NULL, &info, &info);
}
