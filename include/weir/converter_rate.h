 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* An extension of external converters (weir_converter_type's `extension`): frames that say their
 * own frame rate. Without it the stream keeps the rate of the caps that came. */
#ifndef WEIR_CONVERTER_RATE_H
#define WEIR_CONVERTER_RATE_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_CONVERTER_RATE "weir.converter-rate/1"

typedef struct {
  uint32_t struct_size;
  /* After a convert that succeeded: 1 and the frame rate n/d that the frame said (0/1 = none is
   * fixed), or 0 when it said none. Asked on the thread of convert. */
  int (*rate)(weir_converter*, int32_t* n, int32_t* d);
} weir_converter_rate;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CONVERTER_RATE_H */
