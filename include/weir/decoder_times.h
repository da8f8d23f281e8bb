/* An extension of decoders (weir_decoder_type's `extension`) for formats that write times: those of
 * a frame beyond weir_frame, whose pts is of the segment.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_DECODER_TIMES_H
#define WEIR_DECODER_TIMES_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_DECODER_TIMES "weir.decoder-times/1"

typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before each decode, on its thread, in nanoseconds: the frame's running time, and when it
   * was captured, since 1970 UTC. -1 = unknown. */
  void (*set_times)(weir_decoder*, int64_t running_time, int64_t unix_time);
} weir_decoder_times;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_DECODER_TIMES_H */
