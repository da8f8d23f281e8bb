/* An NNStreamer trainer as users write them: accepts everything it receives. WEIR_FAULT_... omits
 * or falsifies something.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <nnstreamer_plugin_api_trainer.h>
#include <stddef.h>

static int create(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                  void** priv) {
  (void)prop;
  *priv = (void*)self;
  return 0;
}

static int destroy(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                   void** priv) {
  (void)self, (void)prop;
  *priv = NULL;
  return 0;
}

static int start(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                 GstTensorTrainerEventNotifier* notifier, void* priv) {
  (void)self, (void)prop, (void)notifier, (void)priv;
  return 0;
}

static int push_data(const GstTensorTrainerFramework* self, const GstTensorTrainerProperties* prop,
                     void* priv, const GstTensorMemory* input) {
  (void)self, (void)prop, (void)priv, (void)input;
  return 0;
}

static int get_status(const GstTensorTrainerFramework* self, GstTensorTrainerProperties* prop,
                      void* priv) {
  (void)self, (void)priv;
  prop->epoch_count = 1;
  return 0;
}

static int get_framework_info(const GstTensorTrainerFramework* self,
                              const GstTensorTrainerProperties* prop, void* priv,
                              GstTensorTrainerFrameworkInfo* info) {
  (void)self, (void)prop, (void)priv;
#ifndef WEIR_FAULT_INFO
  info->name = WEIR_NAME;
  return 0;
#else
  (void)info;
  return -22;
#endif
}

static GstTensorTrainerFramework trainer = {
#ifdef WEIR_FAULT_VERSION
    .version = UINT64_C(0xDEAFDEAD00020000),
#else
    .version = GST_TENSOR_TRAINER_FRAMEWORK_V1,
#endif
    .create = create,
    .destroy = destroy,
    .start = start,
#ifndef WEIR_FAULT_FUNCTIONS
    .stop = destroy,
    .push_data = push_data,
#endif
    .getStatus = get_status,
    .getFrameworkInfo = get_framework_info,
};

__attribute__((constructor)) static void load(void) {
  nnstreamer_trainer_probe(&trainer);
}
