 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* An extension of the host (weir_host's `extension`): input memory that outlives its invoke, for
 * engines that hand it to code which may keep it. */
#ifndef WEIR_HOLD_FRAME_H
#define WEIR_HOLD_FRAME_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_HOLD_FRAME "weir.hold-frame/1"

typedef struct {
  uint32_t struct_size;
  /* Within invoke, on its thread, for the frame that is being invoked: the memory of all its inputs
   * stays as it is, at its place, until release(owner) is called, once, on any thread. 0, or below
   * 0 where the host cannot: batches, worker processes, memory that a program lent for a call. */
  int (*hold)(const weir_frame* in, void (**release)(void* owner), void** owner);
} weir_frame_holder;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_HOLD_FRAME_H */
