/* GTensorFilterSingle: a model of any framework without a pipeline, as a GObject. Its properties
 * are those of tensor_filter. The functions of the class are called by the macros' class pointer:
 *
 *   GTensorFilterSingle* single = g_object_new(G_TYPE_TENSOR_FILTER_SINGLE, NULL);
 *   g_object_set(single, "framework", "tensorflow-lite", "model", "model.tflite", NULL);
 *   G_TENSOR_FILTER_SINGLE_GET_CLASS(single)->invoke(single, in, out, TRUE);
 *
 * One thread at a time.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_FILTER_SINGLE_H
#define NNSTREAMER_TENSOR_FILTER_SINGLE_H
#include <glib-object.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

#define G_TYPE_TENSOR_FILTER_SINGLE (g_tensor_filter_single_get_type())
#define G_TENSOR_FILTER_SINGLE(obj) \
  (G_TYPE_CHECK_INSTANCE_CAST((obj), G_TYPE_TENSOR_FILTER_SINGLE, GTensorFilterSingle))
#define G_TENSOR_FILTER_SINGLE_CLASS(klass) \
  (G_TYPE_CHECK_CLASS_CAST((klass), G_TYPE_TENSOR_FILTER_SINGLE, GTensorFilterSingleClass))
#define G_TENSOR_FILTER_SINGLE_GET_CLASS(obj) \
  (G_TYPE_INSTANCE_GET_CLASS((obj), G_TYPE_TENSOR_FILTER_SINGLE, GTensorFilterSingleClass))
#define G_IS_TENSOR_FILTER_SINGLE(obj) \
  (G_TYPE_CHECK_INSTANCE_TYPE((obj), G_TYPE_TENSOR_FILTER_SINGLE))
#define G_IS_TENSOR_FILTER_SINGLE_CLASS(klass) \
  (G_TYPE_CHECK_CLASS_TYPE((klass), G_TYPE_TENSOR_FILTER_SINGLE))
#define G_TENSOR_FILTER_SINGLE_CAST(obj) ((GTensorFilterSingle*)(obj))

typedef struct _GTensorFilterSingle GTensorFilterSingle;
typedef struct _GTensorFilterSingleClass GTensorFilterSingleClass;

struct _GTensorFilterSingle {
  GObject element;
  gpointer priv;
};

struct _GTensorFilterSingleClass {
  GObjectClass parent;
  /* Starts if necessary. With `allocate`, output[i].size says the size and output[i].data is
   * allocated for the caller, who frees it with destroy_notify; without, the caller gives both. */
  gboolean (*invoke)(GTensorFilterSingle* self, const GstTensorMemory* input,
                     GstTensorMemory* output, gboolean allocate);
  /* Opens the model. TRUE also when it is open already. */
  gboolean (*start)(GTensorFilterSingle* self);
  gboolean (*stop)(GTensorFilterSingle* self);
  /* Whether the tensors are known. */
  gboolean (*input_configured)(GTensorFilterSingle* self);
  gboolean (*output_configured)(GTensorFilterSingle* self);
  /* Sets the shapes of the inputs and fills `out_info`. 0; -EINVAL if it is not started or the
   * framework refuses, -ENOENT if the framework cannot. */
  gint (*set_input_info)(GTensorFilterSingle* self, const GstTensorsInfo* in_info,
                         GstTensorsInfo* out_info);
  /* Whether the framework allocates its outputs. */
  gboolean (*allocate_in_invoke)(GTensorFilterSingle* self);
  /* Frees the data of all outputs and sets it to NULL. */
  void (*destroy_notify)(GTensorFilterSingle* self, GstTensorMemory* output);
  /* Receives the outputs with the property invoke-async. */
  gboolean (*set_invoke_async_callback)(GTensorFilterSingle* self, GstTensorDataCallback callback,
                                        void* user_data);
};

NNS_EXPORT GType g_tensor_filter_single_get_type(void);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_FILTER_SINGLE_H */
