 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* One model, invoked by the program itself: ml_single_*. C99; pkg-config capi-nnstreamer. What
 * stands behind it is weir/model.h, and docs/guide/from-nnstreamer.md says what is there. */
#ifndef NNSTREAMER_SINGLE_H
#define NNSTREAMER_SINGLE_H
#include "ml-tensors.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef void* ml_single_h;

/* Which engine; its framework= of tensor_filter stands beside it. */
typedef enum ML_ANY_INT {
  ML_NNFW_TYPE_ANY = 0,         /* by the name of the model's file */
  ML_NNFW_TYPE_CUSTOM_FILTER,   /* custom-easy for names that are registered, else custom */
  ML_NNFW_TYPE_TENSORFLOW_LITE, /* tensorflow-lite */
  ML_NNFW_TYPE_TENSORFLOW,      /* tensorflow */
  ML_NNFW_TYPE_NNFW,            /* nnfw */
  ML_NNFW_TYPE_MVNC,            /* movidius-ncsdk2 */
  ML_NNFW_TYPE_OPENVINO,        /* openvino */
  ML_NNFW_TYPE_VIVANTE,         /* vivante */
  ML_NNFW_TYPE_EDGE_TPU,        /* edgetpu */
  ML_NNFW_TYPE_ARMNN,           /* armnn */
  ML_NNFW_TYPE_SNPE,            /* snpe */
  ML_NNFW_TYPE_PYTORCH,         /* pytorch */
  ML_NNFW_TYPE_TRIX_ENGINE,     /* trix-engine */
  ML_NNFW_TYPE_TVM,             /* tvm */
  ML_NNFW_TYPE_ONNX_RUNTIME,    /* onnxruntime */
  ML_NNFW_TYPE_NCNN,            /* ncnn */
  ML_NNFW_TYPE_TENSORRT,        /* tensorrt */
  ML_NNFW_TYPE_EXECUTORCH       /* executorch */
} ml_nnfw_type_e;

/* The numbers of accelerator=; ANY and DEFAULT leave the choice to the engine. */
typedef enum ML_ANY_INT {
  ML_NNFW_HW_ANY = 0,
  ML_NNFW_HW_AUTO = 1,
  ML_NNFW_HW_DEFAULT = 2,
  ML_NNFW_HW_CPU = 0x1000,
  ML_NNFW_HW_CPU_SIMD = 0x1100,
  ML_NNFW_HW_CPU_NEON = 0x1100,
  ML_NNFW_HW_GPU = 0x2000,
  ML_NNFW_HW_NPU = 0x4000,
  ML_NNFW_HW_NPU_MOVIDIUS = 0x4001,
  ML_NNFW_HW_NPU_EDGE_TPU = 0x4002,
  ML_NNFW_HW_NPU_VIVANTE = 0x4003,
  ML_NNFW_HW_NPU_SLSI = 0x4005,
  ML_NNFW_HW_NPU_SR = 0x4100
} ml_nnfw_hw_e;

/* Opens `model`, a path or several with commas between them. The infos say what the model does not:
 * NULL where it does. Where both speak they must agree; an info may fix what the model leaves open.
 */
ML_EXPORT int ml_single_open(ml_single_h* single, const char* model,
                             const ml_tensors_info_h input_info,
                             const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                             ml_nnfw_hw_e hw);
/* `custom_option` as custom= of tensor_filter: key:value,key:value; NULL: none. */
ML_EXPORT int ml_single_open_full(ml_single_h* single, const char* model,
                                  const ml_tensors_info_h input_info,
                                  const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                                  ml_nnfw_hw_e hw, const char* custom_option);
/* Does not wait for an invoke of another thread, which ends well. */
ML_EXPORT int ml_single_close(ml_single_h single);

/* *output for ml_tensors_data_destroy. ML_ERROR_TIMED_OUT: see ml_single_set_timeout. */
ML_EXPORT int ml_single_invoke(ml_single_h single, const ml_tensors_data_h input,
                               ml_tensors_data_h* output);
/* Into memory that is there: `output` was created with the info of the outputs. */
ML_EXPORT int ml_single_invoke_fast(ml_single_h single, const ml_tensors_data_h input,
                                    ml_tensors_data_h output);
/* With inputs as in_info says, for models that leave dimensions open: of this invoke only. *output
 * and *out_info are to be destroyed. */
ML_EXPORT int ml_single_invoke_dynamic(ml_single_h single, const ml_tensors_data_h input,
                                       const ml_tensors_info_h in_info, ml_tensors_data_h* output,
                                       ml_tensors_info_h* out_info);

/* As they are now; dimensions that the model leaves open are 1 and ml_tensors_info_validate says
 * false of a tensor without type or rank. *info for ml_tensors_info_destroy. */
ML_EXPORT int ml_single_get_input_info(ml_single_h single, ml_tensors_info_h* info);
ML_EXPORT int ml_single_get_output_info(ml_single_h single, ml_tensors_info_h* info);
/* Sets what the model leaves open. */
ML_EXPORT int ml_single_set_input_info(ml_single_h single, const ml_tensors_info_h info);

/* How long a later invoke may take, in ms; 0: without limit. The engine goes on by itself after
 * ML_ERROR_TIMED_OUT, and each invoke is ML_ERROR_TIMED_OUT until it has ended. */
ML_EXPORT int ml_single_set_timeout(ml_single_h single, unsigned int timeout);

/* Properties of tensor_filter: framework, model, custom, accelerator, inputtype, inputname, output,
 * outputtype, outputname are read; input is read and written, as "4:2,4:2". */
ML_EXPORT int ml_single_set_property(ml_single_h single, const char* name, const char* value);
/* *value for free(). */
ML_EXPORT int ml_single_get_property(ml_single_h single, const char* name, char** value);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_SINGLE_H */
