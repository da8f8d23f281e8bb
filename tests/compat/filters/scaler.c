/* A custom filter that links with the library: scales pictures of uint8 to custom=WIDTHxHEIGHT,
 * nearest pixel.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_custom.h"

struct size {
  unsigned width, height;
};

static void* begin(const GstTensorFilterProperties* prop) {
  struct size* size = calloc(1, sizeof *size);
  if (size && prop->custom_properties)
    sscanf(prop->custom_properties, "%ux%u", &size->width, &size->height);
  return size;
}

static void end(void* priv, const GstTensorFilterProperties* prop) {
  (void)prop;
  free(priv);
}

static int scaled(void* priv, const GstTensorFilterProperties* prop, const GstTensorsInfo* in,
                  GstTensorsInfo* out) {
  const struct size* size = priv;
  (void)prop;
  if (!size || !size->width || gst_tensor_info_get_rank(&in->info[0]) < 3) return -EINVAL;
  gst_tensors_info_copy(out, in);
  out->info[0].dimension[1] = size->width;
  out->info[0].dimension[2] = size->height;
  return 0;
}

static int scale(void* priv, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
                 GstTensorMemory* out) {
  const struct size* size = priv;
  const uint32_t* dim = prop->input_meta.info[0].dimension;
  const char* from = in[0].data;
  char* to = out[0].data;
  size_t x, y;
  for (y = 0; y < size->height; ++y)
    for (x = 0; x < size->width; ++x, to += dim[0])
      memcpy(to, from + (y * dim[2] / size->height * dim[1] + x * dim[1] / size->width) * dim[0],
             dim[0]);
  return 0;
}

static NNStreamer_custom_class callbacks = {
    .initfunc = begin, .exitfunc = end, .setInputDim = scaled, .invoke = scale};
NNStreamer_custom_class* NNStreamer_custom = &callbacks;
