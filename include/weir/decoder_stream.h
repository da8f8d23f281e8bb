/* An extension of decoders (weir_decoder_type's `extension`) for formats that carry properties of
 * the stream: its frame rate, and the headers of flexible tensors.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_DECODER_STREAM_H
#define WEIR_DECODER_STREAM_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_DECODER_STREAM "weir.decoder-stream/1"

/* WITH_HEADERS: in flexible streams, `data` and `bytes` of each tensor include its 128-byte header;
 * `info` still describes the payload, and share_input still appends the payload alone. */
enum weir_decoder_stream_flag { WEIR_DECODER_WITH_HEADERS = 1 };

typedef struct {
  uint32_t struct_size;
  uint32_t flags; /* weir_decoder_stream_flag */
  /* Called before each configure, on its thread: the frame rate n/d of the input (0/1 = variable or
   * unknown), and whether it is flexible. */
  void (*set_stream)(weir_decoder*, int32_t rate_n, int32_t rate_d, int is_flexible);
} weir_decoder_stream;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_DECODER_STREAM_H */
