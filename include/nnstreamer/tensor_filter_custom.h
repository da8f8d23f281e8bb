/* A filter in a shared object: `tensor_filter framework=custom model=/path/to/lib.so`.
 *
 * The object exports one symbol, NNStreamer_custom, a pointer to the callbacks. initfunc is
 * required; set either getInputDim and getOutputDim or setInputDim, and either invoke or
 * allocate_invoke. Functions that return int return 0 on success, below 0 on failure; the invoke
 * functions return above 0 to drop the frame. Calls of one element do not overlap. Needs no library
 * of Weir or GLib.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_FILTER_CUSTOM_H
#define NNSTREAMER_TENSOR_FILTER_CUSTOM_H
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Called once per element, when its model is opened. The result, which may be NULL, is passed to
 * the other functions as `priv`. */
typedef void* (*NNS_custom_init_func)(const GstTensorFilterProperties* prop);
/* Called last; may be NULL. */
typedef void (*NNS_custom_exit_func)(void* priv, const GstTensorFilterProperties* prop);

/* Describe the inputs and outputs if they are fixed. `info` is empty on entry; names are copied and
 * stay with the filter; `extra` is taken over. */
typedef int (*NNS_custom_get_input_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                              GstTensorsInfo* info);
typedef int (*NNS_custom_get_output_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                               GstTensorsInfo* info);
/* Computes the outputs for these inputs; below 0 rejects them. May be called repeatedly. */
typedef int (*NNS_custom_set_input_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                              const GstTensorsInfo* in_info,
                                              GstTensorsInfo* out_info);

/* Writes all bytes of all outputs into the memory provided. */
typedef int (*NNS_custom_invoke)(void* priv, const GstTensorFilterProperties* prop,
                                 const GstTensorMemory* input, GstTensorMemory* output);
/* Same as invoke, but `data` of the outputs is NULL: the function allocates `size` bytes for each.
 * Weir passes them on without a copy and frees each with destroy_notify, or with free() if that is
 * NULL. The sizes are the negotiated ones. */
typedef int (*NNS_custom_allocate_invoke)(void* priv, const GstTensorFilterProperties* prop,
                                          const GstTensorMemory* input, GstTensorMemory* output);
/* Frees one output of allocate_invoke, on any thread. exitfunc is called after the last one. */
typedef void (*NNS_custom_destroy_notify)(void* data);

/* Chooses the sizes for each frame (custom-easy with invoke-dynamic=true): fills out_info,
 * allocates the outputs with malloc() and sets their sizes. */
typedef int (*NNS_custom_invoke_dynamic)(void* priv, const GstTensorsInfo* in_info,
                                         GstTensorsInfo* out_info, const GstTensorMemory* input,
                                         GstTensorMemory* output);

typedef struct _NNStreamer_custom_class {
  NNS_custom_init_func initfunc;
  NNS_custom_exit_func exitfunc;
  NNS_custom_get_input_dimension getInputDim;
  NNS_custom_get_output_dimension getOutputDim;
  NNS_custom_set_input_dimension setInputDim;
  NNS_custom_invoke invoke;
  NNS_custom_allocate_invoke allocate_invoke;
  NNS_custom_destroy_notify destroy_notify;
} NNStreamer_custom_class;

/* The filter defines it once. */
extern NNS_EXPORT NNStreamer_custom_class* NNStreamer_custom;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_FILTER_CUSTOM_H */
