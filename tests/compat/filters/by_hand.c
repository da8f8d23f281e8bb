/* A custom filter with the published layouts and no header: float32 4 times the number in custom=.
 * Drops frames whose first value is above 100, and fails below -100.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdlib.h>

#include "../by_hand.h"

struct callbacks {
  void* (*begin)(const void* prop);
  void (*end)(void* priv, const void* prop);
  int (*inputs)(void* priv, const void* prop, struct tensors*);
  int (*outputs)(void* priv, const void* prop, struct tensors*);
  int (*set_inputs)(void* priv, const void* prop, const struct tensors*, struct tensors*);
  int (*invoke)(void* priv, const void* prop, const struct memory*, struct memory*);
  int (*allocate_invoke)(void* priv, const void* prop, const struct memory*, struct memory*);
  void (*free_output)(void* data);
};

enum { CUSTOM_PROPERTIES = 6744, FLOAT32 = 7 };

static void* begin(const void* prop) {
  const char* text;
  float* factor = malloc(sizeof *factor);
  text = *(const char* const*)((const char*)prop + CUSTOM_PROPERTIES);
  *factor = text ? (float)atof(text) : 1;
  return factor;
}

static void end(void* priv, const void* prop) {
  (void)prop;
  free(priv);
}

static int four_floats(void* priv, const void* prop, struct tensors* out) {
  (void)priv;
  (void)prop;
  out->num = 1;
  out->first[0].type = FLOAT32;
  out->first[0].dimension[0] = 4;
  return 0;
}

static int scale(void* priv, const void* prop, const struct memory* in, struct memory* out) {
  const float* x = in[0].data;
  float* y = out[0].data;
  size_t i;
  (void)prop;
  if (x[0] > 100) return 1;
  if (x[0] < -100) return -22;
  for (i = 0; i < out[0].size / sizeof *y; ++i) y[i] = *(float*)priv * x[i];
  return 0;
}

static struct callbacks callbacks = {begin, end, four_floats, four_floats, 0, scale, 0, 0};
extern struct callbacks* NNStreamer_custom;
__attribute__((visibility("default"))) struct callbacks* NNStreamer_custom = &callbacks;
