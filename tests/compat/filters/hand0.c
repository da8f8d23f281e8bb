/* A filter sub-plugin of version 0 with the published layouts and no header: doubles int32 of any
 * dimension.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <stdlib.h>
#include <string.h>

#include "../by_hand.h"

struct framework {
  uint64_t version;
  int (*open)(const void* prop, void** priv);
  void (*close)(const void* prop, void** priv);
  const char* name;
  int in_place, allocates, no_model, verify;
  const void* statistics;
  int (*invoke)(const void* prop, void** priv, const struct memory*, struct memory*);
  int (*inputs)(const void* prop, void** priv, struct tensors*);
  int (*outputs)(const void* prop, void** priv, struct tensors*);
  int (*set_inputs)(const void* prop, void** priv, const struct tensors*, struct tensors*);
  void (*free_output)(void** priv, void* data);
  int (*reload)(const void* prop, void** priv);
  int (*event)(int op, void* data);
  int (*available)(int hardware);
  int (*allocates_now)(void** priv);
};

extern int nnstreamer_filter_probe(struct framework*);

static int begin(const void* prop, void** priv) {
  (void)prop;
  *priv = malloc(sizeof(int));
  *(int*)*priv = 2;
  return 0;
}
static void end(const void* prop, void** priv) {
  (void)prop;
  free(*priv);
}
static int same(const void* prop, void** priv, const struct tensors* in, struct tensors* out) {
  (void)prop;
  (void)priv;
  if (in->num != 1 || in->first[0].type != 0) return -22;
  out->num = 1;
  out->first[0].type = 0;
  memcpy(out->first[0].dimension, in->first[0].dimension, sizeof out->first[0].dimension);
  return 0;
}
static int twice(const void* prop, void** priv, const struct memory* in, struct memory* out) {
  size_t i;
  (void)prop;
  for (i = 0; i < in[0].size / 4; ++i)
    ((int32_t*)out[0].data)[i] = *(int*)*priv * ((const int32_t*)in[0].data)[i];
  return 0;
}

static struct framework framework = {.version = 0xDEAFDEAD00000000u,
                                     .open = begin,
                                     .close = end,
                                     .name = "hand0",
                                     .no_model = 1,
                                     .invoke = twice,
                                     .set_inputs = same};

__attribute__((constructor)) static void add(void) {
  nnstreamer_filter_probe(&framework);
}
