/* An extension of an engine (weir_engine's `extension`) that reports counts of its own for an open
 * model. `tensor_filter` shows them in `stats`.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_ENGINE_STATISTICS_H
#define WEIR_ENGINE_STATISTICS_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_ENGINE_STATISTICS "weir.statistics/1"

/* FROZEN. */
typedef struct {
  const char* name; /* lower case with hyphens; valid until the process ends */
  uint64_t value;
} weir_statistic;

typedef struct {
  uint32_t struct_size;
  /* Writes up to `room` statistics of an open model. Returns how many it has, or below 0. Any
   * thread, also during an invoke. */
  int (*read)(weir_model*, weir_statistic* out, uint32_t room);
} weir_engine_statistics;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ENGINE_STATISTICS_H */
