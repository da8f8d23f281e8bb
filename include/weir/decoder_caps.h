/* An extension of decoders (weir_decoder_type's `extension`) for formats that carry more of the
 * stream than its tensors: the other fields of the input caps, such as weir-columns (results.h).
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_DECODER_CAPS_H
#define WEIR_DECODER_CAPS_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_DECODER_CAPS "weir.decoder-caps/1"

typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before each configure, on its thread: the text fields of the input caps, by name. Valid
   * for the call. */
  void (*set_caps)(weir_decoder*, const weir_option* fields, uint32_t n);
} weir_decoder_caps;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_DECODER_CAPS_H */
