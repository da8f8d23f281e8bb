/* An extension of the host (weir_host's `extension`) that keeps input memory valid beyond its
 * invoke, for engines that pass it to code which may retain it.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_HOLD_FRAME_H
#define WEIR_HOLD_FRAME_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_HOLD_FRAME "weir.hold-frame/1"

typedef struct {
  uint32_t struct_size;
  /* Call it on the thread of invoke for the frame being invoked. The memory of all its inputs stays
   * valid and unchanged until release(owner) is called, once, on any thread. Returns 0, or below 0
   * when the host cannot: batches, worker processes, memory that a program lent for a call. */
  int (*hold)(const weir_frame* in, void (**release)(void* owner), void** owner);
} weir_frame_holder;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_HOLD_FRAME_H */
