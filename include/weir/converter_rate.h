/* An extension of external converters (weir_converter_type's `extension`) for formats whose frames
 * carry their own frame rate. Without it the stream keeps the rate of its input caps.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CONVERTER_RATE_H
#define WEIR_CONVERTER_RATE_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_CONVERTER_RATE "weir.converter-rate/1"

typedef struct {
  uint32_t struct_size;
  /* Called after a convert that succeeded, on its thread. Returns 1 and the frame rate n/d that the
   * frame carried (0/1 = variable), or 0 when it carried none. */
  int (*rate)(weir_converter*, int32_t* n, int32_t* d);
} weir_converter_rate;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CONVERTER_RATE_H */
