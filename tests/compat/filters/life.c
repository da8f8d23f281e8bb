/* A filter sub-plugin of version 0, `life`, that adds the number in its model's file to float32 4
 * and tells its life to the pipe custom=FD: o(pen), c(lose), s(uspend), r(esume). A FD with a + in
 * front: it knows suspend and resume. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "nnstreamer_plugin_api_filter.h"

static int pipe_end, sleeps;

static void tell(char what) {
  if (write(pipe_end, &what, 1) != 1) abort();
}

static int begin(const GstTensorFilterProperties* prop, void** priv) {
  FILE* file = fopen(prop->model_files[0], "r");
  float* number = malloc(sizeof *number);
  const int good = file && number && fscanf(file, "%f", number) == 1;
  if (file) fclose(file);
  if (!good) {
    free(number);
    return -EIO;
  }
  sleeps = prop->custom_properties[0] == '+';
  pipe_end = atoi(prop->custom_properties);
  tell('o');
  *priv = number;
  return 0;
}

static void end(const GstTensorFilterProperties* prop, void** priv) {
  (void)prop;
  tell('c');
  free(*priv);
}

static int four(const GstTensorFilterProperties* prop, void** priv, GstTensorsInfo* info) {
  (void)prop;
  (void)priv;
  info->num_tensors = 1;
  info->info[0].type = _NNS_FLOAT32;
  info->info[0].dimension[0] = 4;
  return 0;
}

static int add(const GstTensorFilterProperties* prop, void** priv, const GstTensorMemory* in,
               GstTensorMemory* out) {
  int i;
  (void)prop;
  for (i = 0; i < 4; ++i)
    ((float*)out[0].data)[i] = ((const float*)in[0].data)[i] + *(const float*)*priv;
  return 0;
}

static int event(event_ops op, GstTensorFilterFrameworkEventData* data) {
  (void)data;
  if (!sleeps || (op != SUSPEND && op != RESUME)) return -ENOENT;
  tell(op == SUSPEND ? 's' : 'r');
  return 0;
}

static GstTensorFilterFramework framework;

__attribute__((constructor)) static void begin_all(void) {
  static char name[] = "life";
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V0;
  framework.open = begin;
  framework.close = end;
  framework.name = name;
  framework.verify_model_path = 1;
  framework.invoke_NN = add;
  framework.getInputDimension = four;
  framework.getOutputDimension = four;
  framework.handleEvent = event;
  nnstreamer_filter_probe(&framework);
}
