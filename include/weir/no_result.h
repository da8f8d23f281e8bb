/* Return values of invoke (weir_engine in abi.h) that say why a frame has no result. Values above 0
 * that are not listed here mean WEIR_NO_RESULT.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_NO_RESULT_H
#define WEIR_NO_RESULT_H

/* An engine with submit() says it with the last complete() of a request. After the last three, the
 * host may run another model on the frame (tensor_filter fallback=...). `stats` counts the frames
 * as dropped-policy, dropped-late, dropped-refused and dropped-lost. */
enum weir_no_result {
  WEIR_NO_RESULT = 1,            /* the engine drops the frame */
  WEIR_RESULT_LATE = 0x57450001, /* the result did not come in time */
  WEIR_RESULT_REFUSED,           /* another process or machine rejected the frame */
  WEIR_RESULT_LOST               /* another process or machine has ended, or cannot be reached */
};

#endif /* WEIR_NO_RESULT_H */
