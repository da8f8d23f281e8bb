/* Pipelines of one sink callback, which keeps the last frame. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef SEEN_TEST_SUPPORT_H
#define SEEN_TEST_SUPPORT_H
#include "nnstreamer.h"
#include "wait_test_support.h"

typedef struct {
  Counter frames;
  float last;
  unsigned int width;
  ml_pipeline_h pipe;
  ml_pipeline_sink_h sink;
  ml_tensors_data_h data;
} Seen;

#define SEEN \
  { COUNTER, 0, 0, NULL, NULL, NULL }

static inline void see(const ml_tensors_data_h data, const ml_tensors_info_h info,
                       void* user_data) {
  Seen* seen = user_data;
  void* memory = NULL;
  size_t size = 0;
  ml_tensor_dimension dimension;
  OK(ml_tensors_data_get_tensor_data(data, 0, &memory, &size));
  OK(ml_tensors_info_get_tensor_dimension(info, 0, dimension));
  CHECK(size == dimension[0] * sizeof(float));
  seen->last = ((const float*)memory)[0];
  seen->width = dimension[0];
  seen->data = data;
  raise_count(&seen->frames);
}

static inline ml_pipeline_h construct(const char* text) {
  ml_pipeline_h pipe = NULL;
  OK(ml_pipeline_construct(text, NULL, NULL, &pipe));
  return pipe;
}
#endif
