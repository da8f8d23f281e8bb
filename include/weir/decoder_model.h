/* An extension of decoders (weir_decoder_type's `extension`): what is known of the model whose
 * outputs the decoder reads. tensor_filter sends it downstream with its stream.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_DECODER_MODEL_H
#define WEIR_DECODER_MODEL_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_DECODER_MODEL "weir.decoder-model/1"

/* Valid for the call. Tensors have the names and the quantisation of the model file. */
typedef struct {
  uint32_t struct_size;
  uint32_t n_inputs, n_outputs;
  const weir_tensor_info *inputs, *outputs;
  const char* path;          /* of the model file, or NULL */
  const char* metadata_json; /* an object of strings, as in weir_model_info, or NULL */
  /* Names of classes in the model's card. Check struct_size before you read them. */
  const char* const* card_labels;
  uint32_t n_card_labels;
} weir_stream_model;

typedef struct {
  uint32_t struct_size;
  uint32_t reserved;
  /* Called before configure, on its thread. NULL: the stream's model is not known. Outputs are
   * those of the stream: the host passes a model only if types and shapes are equal. */
  void (*set_model)(weir_decoder*, const weir_stream_model*);
} weir_decoder_model;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_DECODER_MODEL_H */
