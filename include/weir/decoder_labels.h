/* An extension of decoders (weir_decoder_type's `extension`): names of classes. A decoder that
 * writes results reports those of its results, and the host sends them downstream with the stream;
 * a decoder that reads results receives those of the sources in weir-source (results.h).
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_DECODER_LABELS_H
#define WEIR_DECODER_LABELS_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_DECODER_LABELS "weir.decoder-labels/1"

typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called after configure, on its thread: the number of names, which are those of class 0 and the
   * classes after it; 0 = not known. They stay valid until the next call of the decoder. NULL: the
   * decoder writes no results. */
  uint32_t (*labels)(weir_decoder*, const char* const** names);
  /* Called before configure and between frames: the names of the classes of one source, valid for
   * the call. NULL: the decoder does not use them. */
  void (*set_labels)(weir_decoder*, const char* source, const char* const* names, uint32_t n);
  /* Called after configure: the number of classes that the model tells apart; 0 = not known. The
   * host warns of fewer names than that. NULL, or beyond struct_size: not known. */
  uint32_t (*classes)(weir_decoder*);
} weir_decoder_labels;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_DECODER_LABELS_H */
