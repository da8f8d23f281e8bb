 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* An extension of an engine (weir_engine's `extension`): how it runs a model, where it chose that
 * itself. `tensor_filter` shows it in `stats`. */
#ifndef WEIR_EXECUTION_H
#define WEIR_EXECUTION_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_EXECUTION "weir.execution/1"

typedef struct {
  uint32_t struct_size; /* set by the caller; members beyond it stay as they are */
  uint32_t threads;     /* of one invoke; 0 = not chosen yet: the input shapes decide */
  uint32_t spins;       /* 1: between two operators these threads wait without sleeping */
} weir_execution;

typedef struct {
  uint32_t struct_size;
  /* Describes an open model at present: resolve() may change it. Any thread. Returns 0, or below 0
   * when the engine cannot tell. */
  int (*describe)(weir_model*, weir_execution*);
} weir_execution_calls;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_EXECUTION_H */
