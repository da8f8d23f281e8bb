/* An extension of external converters (weir_converter_type's `extension`) for formats whose frames
 * may hold flexible tensors. Without it the output is static.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CONVERTER_STREAM_H
#define WEIR_CONVERTER_STREAM_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_CONVERTER_STREAM "weir.converter-stream/1"

typedef struct {
  uint32_t struct_size;
  /* Called after a convert that succeeded, on its thread. Nonzero: the tensors of that frame are
   * flexible. Each begins with its 128-byte header, which `bytes` includes and which the host
   * compares with `info`. */
  int (*is_flexible)(weir_converter*);
} weir_converter_stream;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_CONVERTER_STREAM_H */
