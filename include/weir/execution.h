/* An extension of an engine (weir_engine's `extension`) that reports the execution settings which
 * the engine chose for a model. `tensor_filter` shows them in `stats`.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_EXECUTION_H
#define WEIR_EXECUTION_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_EXECUTION "weir.execution/1"

typedef struct {
  uint32_t struct_size; /* set by the caller; later members are not written */
  uint32_t threads;     /* of one invoke; 0 = not chosen yet: depends on the input shapes */
  uint32_t spins;       /* 1: idle threads spin between operators instead of sleeping */
} weir_execution;

typedef struct {
  uint32_t struct_size;
  /* Describes an open model; resolve() may change the result. Any thread. Returns 0, or below 0
   * when the engine does not know. */
  int (*describe)(weir_model*, weir_execution*);
} weir_execution_calls;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_EXECUTION_H */
