/* The published data layouts, written by hand without include/nnstreamer. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef BY_HAND_H
#define BY_HAND_H
#include <stddef.h>
#include <stdint.h>

struct tensor {
  char* name;
  int type;
  uint32_t dimension[16];
};
struct tensors {
  unsigned num;
  struct tensor first[16];
  struct tensor* more;
  int format;
};
struct config {
  struct tensors info;
  int rate_n, rate_d;
};
struct memory {
  void* data;
  size_t size;
};
#endif
