/* Opens and invokes one model without a pipeline: ml_single_*. C99; pkg-config capi-nnstreamer.
 * Implemented with weir/model.h; docs/guide/from-nnstreamer.md lists the coverage.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_SINGLE_H
#define NNSTREAMER_SINGLE_H
#include "ml-tensors.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef void* ml_single_h;

/* Engines; the comments give their framework= of tensor_filter. */
typedef enum ML_ANY_INT {
  ML_NNFW_TYPE_ANY = 0,         /* chosen by the name of the model file */
  ML_NNFW_TYPE_CUSTOM_FILTER,   /* custom-easy for registered names, else custom */
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

/* Values of accelerator=; ANY and DEFAULT leave the choice to the engine. */
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

/* Opens `model`, a path or several separated by commas. The infos describe tensors that the model
 * does not describe; otherwise pass NULL. They must agree with the model and may fix what it leaves
 * open. */
ML_EXPORT int ml_single_open(ml_single_h* single, const char* model,
                             const ml_tensors_info_h input_info,
                             const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                             ml_nnfw_hw_e hw);
/* `custom_option` is custom= of tensor_filter: key:value,key:value; NULL: none. */
ML_EXPORT int ml_single_open_full(ml_single_h* single, const char* model,
                                  const ml_tensors_info_h input_info,
                                  const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                                  ml_nnfw_hw_e hw, const char* custom_option);
/* Does not wait for an invoke on another thread, which completes normally. */
ML_EXPORT int ml_single_close(ml_single_h single);

/* Free *output with ml_tensors_data_destroy. ML_ERROR_TIMED_OUT: see ml_single_set_timeout. */
ML_EXPORT int ml_single_invoke(ml_single_h single, const ml_tensors_data_h input,
                               ml_tensors_data_h* output);
/* Invokes into existing memory: create `output` with the info of the outputs. */
ML_EXPORT int ml_single_invoke_fast(ml_single_h single, const ml_tensors_data_h input,
                                    ml_tensors_data_h output);
/* Invokes once with inputs as described by in_info, for models with open dimensions. Destroy
 * *output and *out_info. */
ML_EXPORT int ml_single_invoke_dynamic(ml_single_h single, const ml_tensors_data_h input,
                                       const ml_tensors_info_h in_info, ml_tensors_data_h* output,
                                       ml_tensors_info_h* out_info);

/* The current tensors. Open dimensions are 1; a tensor without type or rank makes
 * ml_tensors_info_validate return false. Free *info with ml_tensors_info_destroy. */
ML_EXPORT int ml_single_get_input_info(ml_single_h single, ml_tensors_info_h* info);
ML_EXPORT int ml_single_get_output_info(ml_single_h single, ml_tensors_info_h* info);
/* Sets the dimensions that the model leaves open. */
ML_EXPORT int ml_single_set_input_info(ml_single_h single, const ml_tensors_info_h info);

/* Limits the duration of later invokes, in ms; 0: no limit. After ML_ERROR_TIMED_OUT the engine
 * continues, and until it ends every invoke returns ML_ERROR_TIMED_OUT. */
ML_EXPORT int ml_single_set_timeout(ml_single_h single, unsigned int timeout);

/* Properties of tensor_filter. Readable: framework, model, custom, accelerator, inputtype,
 * inputname, output, outputtype, outputname. Readable and writable: input, as "4:2,4:2". */
ML_EXPORT int ml_single_set_property(ml_single_h single, const char* name, const char* value);
/* Free *value with free(). */
ML_EXPORT int ml_single_get_property(ml_single_h single, const char* name, char** value);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_SINGLE_H */
