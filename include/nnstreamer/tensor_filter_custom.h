 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* A filter in a shared object: `tensor_filter framework=custom model=/path/to/lib.so`.
 *
 * The object exports one symbol, NNStreamer_custom, a pointer to the callbacks. initfunc must be
 * there; either getInputDim and getOutputDim, or setInputDim, not both; one of invoke and
 * allocate_invoke, not both. Functions that return int: 0 = done, below 0 = failed, and of the
 * invokes above 0 = nothing comes of this frame. Calls of one element do not overlap.
 * Needs no library of Weir or GLib. */
#ifndef NNSTREAMER_TENSOR_FILTER_CUSTOM_H
#define NNSTREAMER_TENSOR_FILTER_CUSTOM_H
#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Called once for an element, when its model is opened; what it returns comes back as `priv`, NULL
 * is allowed. */
typedef void* (*NNS_custom_init_func)(const GstTensorFilterProperties* prop);
/* Called last; may be NULL. */
typedef void (*NNS_custom_exit_func)(void* priv, const GstTensorFilterProperties* prop);

/* Say what the filter takes and gives, where that is fixed. `info` comes empty; names that are put
 * in are copied, so they stay whose they are; `extra` is taken over. */
typedef int (*NNS_custom_get_input_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                              GstTensorsInfo* info);
typedef int (*NNS_custom_get_output_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                               GstTensorsInfo* info);
/* Says what the filter gives for inputs of these; below 0 refuses them. May be called more than
 * once. */
typedef int (*NNS_custom_set_input_dimension)(void* priv, const GstTensorFilterProperties* prop,
                                              const GstTensorsInfo* in_info,
                                              GstTensorsInfo* out_info);

/* Writes all bytes of all outputs; their memory is there. */
typedef int (*NNS_custom_invoke)(void* priv, const GstTensorFilterProperties* prop,
                                 const GstTensorMemory* input, GstTensorMemory* output);
/* As invoke, but `data` of the outputs is NULL: the function allocates each one, `size` bytes.
 * Weir gives them on without a copy and frees each with destroy_notify, or with free() where that
 * is NULL. The sizes are those that were agreed. */
typedef int (*NNS_custom_allocate_invoke)(void* priv, const GstTensorFilterProperties* prop,
                                          const GstTensorMemory* input, GstTensorMemory* output);
/* Frees one output of allocate_invoke, on any thread; exitfunc comes behind the last one. */
typedef void (*NNS_custom_destroy_notify)(void* data);

/* Says sizes with each frame (custom-easy with invoke-dynamic=true): fills out_info, allocates the
 * outputs with malloc() and sets their sizes. */
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

/* Defined by the filter, once. */
extern NNS_EXPORT NNStreamer_custom_class* NNStreamer_custom;

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_FILTER_CUSTOM_H */
