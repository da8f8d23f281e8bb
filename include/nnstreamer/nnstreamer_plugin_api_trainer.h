/* Trainer sub-plugins for tensor_trainer: frameworks that train models.
 *
 * A sub-plugin is a shared object libnnstreamer_trainer_NAME.so whose constructor calls
 * nnstreamer_trainer_probe(). Functions that return int return 0 on success, below 0 on failure.
 * This version of Weir loads, checks and lists trainers; the element does not exist yet.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_TRAINER_H
#define NNSTREAMER_PLUGIN_API_TRAINER_H
#include <glib.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The required `version` of descriptors and notifiers. */
#define GST_TENSOR_TRAINER_FRAMEWORK_BASE (UINT64_C(0xDEAFDEAD00000000))
#define GST_TENSOR_TRAINER_FRAMEWORK_V1 (GST_TENSOR_TRAINER_FRAMEWORK_BASE | UINT64_C(0x10000))

/* The element's properties, and the progress reported by the framework. */
typedef struct _GstTensorTrainerProperties {
  GstTensorsInfo input_meta;
  const char *model_config, *model_save_path, *model_load_path;
  unsigned int num_inputs, num_labels;
  unsigned int num_training_samples, num_validation_samples;
  unsigned int num_epochs, epoch_count;
  double training_loss, training_accuracy;
  double validation_loss, validation_accuracy;
} GstTensorTrainerProperties;

typedef struct _GstTensorTrainerFrameworkInfo {
  const char* name;
} GstTensorTrainerFrameworkInfo;

typedef struct _GstTensorTrainerEventNotifier {
  uint64_t version;
  void* notifier;
} GstTensorTrainerEventNotifier;

typedef enum _GstTensorTrainerEventType {
  TRAINER_EVENT_EPOCH_COMPLETION = 0,
  TRAINER_EVENT_TRAINING_COMPLETION = 1,
  TRAINER_EVENT_UNKNOWN = 2
} GstTensorTrainerEventType;

typedef struct _GstTensorTrainerFramework GstTensorTrainerFramework;

/* A descriptor. It must stay valid until nnstreamer_trainer_exit(). All functions are required. */
struct _GstTensorTrainerFramework {
  uint64_t version;
  int (*create)(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                void** priv);
  int (*destroy)(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                 void** priv);
  int (*start)(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
               GstTensorTrainerEventNotifier* notifier, void* priv);
  int (*stop)(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
              void** priv);
  int (*push_data)(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                   void* priv, const GstTensorMemory* input);
  int (*getStatus)(const GstTensorTrainerFramework* self, GstTensorTrainerProperties* prop,
                   void* priv);
  int (*getFrameworkInfo)(const GstTensorTrainerFramework* self,
                          const GstTensorTrainerProperties* prop, void* priv,
                          GstTensorTrainerFrameworkInfo* info);
};

/* Registers it under the name from getFrameworkInfo. TRUE, or FALSE with the reason in the log. */
NNS_EXPORT int nnstreamer_trainer_probe(GstTensorTrainerFramework* framework);
/* Releases the name. TRUE, or FALSE if it was not registered. */
NNS_EXPORT int nnstreamer_trainer_exit(GstTensorTrainerFramework* framework);
/* Reports the end of an epoch or of the training; `data` belongs to the event and may be NULL. */
NNS_EXPORT void nnstreamer_trainer_notify_event(GstTensorTrainerEventNotifier* notifier,
                                                GstTensorTrainerEventType event, void* data);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_TRAINER_H */
