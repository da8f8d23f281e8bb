/* Errors, numbers, tensor descriptions (ml_tensors_info_*), tensor memory (ml_tensors_data_*) and
 * options, shared by nnstreamer.h and nnstreamer-single.h, which include this header. C99; link
 * with pkg-config capi-ml-common. docs/compatibility/app-api.md 8.7 has what programs rely on.
 *
 * Handles are numbers that are never reused: every call detects NULL, handles of another kind and
 * destroyed handles, and returns ML_ERROR_INVALID_PARAMETER with the reason in ml_error(). Any
 * thread may call.
 *
 * Functions return ML_ERROR_NONE or a value below 0. Output pointers are set on success; a failed
 * call leaves their target as it was, except where documented.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef ML_API_COMMON_H
#define ML_API_COMMON_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "tizen_error.h"

#ifndef ML_EXPORT
#define ML_EXPORT __attribute__((visibility("default")))
#endif

/* In C++ these enums accept any int, as in C, so that invalid arguments can be checked. */
#ifdef __cplusplus
#define ML_ANY_INT : int
#else
#define ML_ANY_INT
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ML_ANY_INT {
  ML_ERROR_NONE = TIZEN_ERROR_NONE,
  ML_ERROR_INVALID_PARAMETER = TIZEN_ERROR_INVALID_PARAMETER, /* a handle, name or value */
  ML_ERROR_STREAMS_PIPE = TIZEN_ERROR_STREAMS_PIPE,           /* a pipeline or a model has failed */
  ML_ERROR_TRY_AGAIN = TIZEN_ERROR_TRY_AGAIN, /* not in this state or not from this callback */
  ML_ERROR_UNKNOWN = TIZEN_ERROR_UNKNOWN,     /* internal error, described in ml_error() */
  ML_ERROR_TIMED_OUT = TIZEN_ERROR_TIMED_OUT, /* see ml_single_set_timeout */
  ML_ERROR_NOT_SUPPORTED = TIZEN_ERROR_NOT_SUPPORTED, /* an engine is missing, or an element is
                                                         not in [element-restriction] */
  ML_ERROR_PERMISSION_DENIED = TIZEN_ERROR_PERMISSION_DENIED, /* data that is read-only */
  ML_ERROR_OUT_OF_MEMORY = TIZEN_ERROR_OUT_OF_MEMORY,
  ML_ERROR_IO_ERROR = TIZEN_ERROR_IO_ERROR /* a file cannot be read or written */
} ml_error_e;

/* The reason of this thread's last failed call: what failed, what was offered and needed, the first
 * difference, a line to paste; at most 4095 bytes. NULL if no call has failed since the last
 * ml_error(). Valid until this thread's next failure. */
ML_EXPORT const char* ml_error(void);
/* The error number of the last failed call, documented in docs/errors/WEIR-<number>.md; 0 before
 * the first failure. */
ML_EXPORT int ml_error_number(void);
/* What a value of ml_error_e means, with or without its sign; NULL for 0 and other numbers. */
ML_EXPORT const char* ml_strerror(int error_code);

/* The version of NNStreamer's application API that this library follows. Pointers may be NULL. */
ML_EXPORT void ml_api_get_version(unsigned int* major, unsigned int* minor, unsigned int* micro);
/* "Machine Learning API 1.8.8"; free it with free(). */
ML_EXPORT char* ml_api_get_version_string(void);

#define ML_TENSOR_RANK_LIMIT (16)
#define ML_TENSOR_SIZE_LIMIT (256) /* tensors of a frame */
/* Innermost first; entries beyond the rank are 0. */
typedef unsigned int ml_tensor_dimension[ML_TENSOR_RANK_LIMIT];

typedef enum ML_ANY_INT {
  ML_TENSOR_TYPE_INT32 = 0,
  ML_TENSOR_TYPE_UINT32,
  ML_TENSOR_TYPE_INT16,
  ML_TENSOR_TYPE_UINT16,
  ML_TENSOR_TYPE_INT8,
  ML_TENSOR_TYPE_UINT8,
  ML_TENSOR_TYPE_FLOAT64,
  ML_TENSOR_TYPE_FLOAT32,
  ML_TENSOR_TYPE_INT64,
  ML_TENSOR_TYPE_UINT64,
  ML_TENSOR_TYPE_FLOAT16,
  ML_TENSOR_TYPE_UNKNOWN
} ml_tensor_type_e;

/* Engines; the comments give their framework= of tensor_filter. */
typedef enum ML_ANY_INT {
  ML_NNFW_TYPE_ANY = 0,             /* chosen by the name of the model file */
  ML_NNFW_TYPE_CUSTOM_FILTER = 1,   /* custom, or custom-easy for a registered name */
  ML_NNFW_TYPE_TENSORFLOW_LITE = 2, /* tensorflow-lite */
  ML_NNFW_TYPE_TENSORFLOW = 3,      /* tensorflow */
  ML_NNFW_TYPE_NNFW = 4,            /* nnfw */
  ML_NNFW_TYPE_MVNC = 5,            /* movidius-ncsdk2 */
  ML_NNFW_TYPE_OPENVINO = 6,        /* openvino */
  ML_NNFW_TYPE_VIVANTE = 7,         /* vivante */
  ML_NNFW_TYPE_EDGE_TPU = 8,        /* edgetpu */
  ML_NNFW_TYPE_ARMNN = 9,           /* armnn */
  ML_NNFW_TYPE_SNPE = 10,           /* snpe */
  ML_NNFW_TYPE_PYTORCH = 11,        /* pytorch */
  ML_NNFW_TYPE_NNTR_INF = 12,       /* nntrainer */
  ML_NNFW_TYPE_VD_AIFW = 13,        /* vd_aifw */
  ML_NNFW_TYPE_TRIX_ENGINE = 14,    /* trix-engine */
  ML_NNFW_TYPE_MXNET = 15,          /* mxnet */
  ML_NNFW_TYPE_TVM = 16,            /* tvm */
  ML_NNFW_TYPE_ONNX_RUNTIME = 17,   /* onnxruntime */
  ML_NNFW_TYPE_NCNN = 18,           /* ncnn */
  ML_NNFW_TYPE_TENSORRT = 19,       /* tensorrt */
  ML_NNFW_TYPE_QNN = 20,            /* qnn */
  ML_NNFW_TYPE_LLAMACPP = 21,       /* llamacpp */
  ML_NNFW_TYPE_TIZEN_HAL = 22,      /* tizen-hal */
  ML_NNFW_TYPE_SNAP = 0x2001,       /* snap */
  ML_NNFW_TYPE_EXECUTORCH = 0x5701  /* executorch; not in NNStreamer */
} ml_nnfw_type_e;

/* Hardware. Other numbers count as AUTO. */
typedef enum ML_ANY_INT {
  ML_NNFW_HW_ANY = 0, /* the engine's default */
  ML_NNFW_HW_AUTO = 1,
  ML_NNFW_HW_CPU = 0x1000,
  ML_NNFW_HW_CPU_SIMD = 0x1100,
  ML_NNFW_HW_CPU_NEON = 0x1100,
  ML_NNFW_HW_GPU = 0x2000,
  ML_NNFW_HW_NPU = 0x3000,
  ML_NNFW_HW_NPU_MOVIDIUS = 0x3001,
  ML_NNFW_HW_NPU_EDGE_TPU = 0x3002,
  ML_NNFW_HW_NPU_VIVANTE = 0x3003,
  ML_NNFW_HW_NPU_SLSI = 0x3004,
  ML_NNFW_HW_NPU_SR = 0x13000
} ml_nnfw_hw_e;

typedef void* ml_tensors_info_h;
typedef void* ml_tensors_data_h;
typedef void* ml_option_h;
typedef void* ml_information_h;
typedef void* ml_information_list_h;

/* Creates an info without tensors. It is plain: it reads the first four entries of the dimensions
 * that it is given, as programs written for four dimensions need. */
ML_EXPORT int ml_tensors_info_create(ml_tensors_info_h* info);
/* Creates an info without tensors that reads all ML_TENSOR_RANK_LIMIT entries. Infos that the
 * library makes are extended if a tensor has more than four dimensions. */
ML_EXPORT int ml_tensors_info_create_extended(ml_tensors_info_h* info);
ML_EXPORT int ml_tensors_info_destroy(ml_tensors_info_h info);
/* *valid: at least one tensor, and each has a type and dimensions. */
ML_EXPORT int ml_tensors_info_validate(const ml_tensors_info_h info, bool* valid);
/* Replaces the content of `dest` with a deep copy of `src`, which must be valid. `dest` becomes
 * plain or extended as `src` is. */
ML_EXPORT int ml_tensors_info_clone(ml_tensors_info_h dest, const ml_tensors_info_h src);
/* 1 to ML_TENSOR_SIZE_LIMIT. A new tensor has no type, dimensions or name; a tensor that a lower
 * count has hidden comes back as it was. */
ML_EXPORT int ml_tensors_info_set_count(ml_tensors_info_h info, unsigned int count);
ML_EXPORT int ml_tensors_info_get_count(ml_tensors_info_h info, unsigned int* count);
/* `index` must be below the count. A NULL name removes the name. */
ML_EXPORT int ml_tensors_info_set_tensor_name(ml_tensors_info_h info, unsigned int index,
                                              const char* name);
/* Free *name with free(); NULL if the tensor has no name. */
ML_EXPORT int ml_tensors_info_get_tensor_name(ml_tensors_info_h info, unsigned int index,
                                              char** name);
ML_EXPORT int ml_tensors_info_set_tensor_type(ml_tensors_info_h info, unsigned int index,
                                              ml_tensor_type_e type);
ML_EXPORT int ml_tensors_info_get_tensor_type(ml_tensors_info_h info, unsigned int index,
                                              ml_tensor_type_e* type);
/* At least one entry that is not 0, and only zeros after the first 0, among the entries that the
 * info reads. */
ML_EXPORT int ml_tensors_info_set_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   const ml_tensor_dimension dimension);
/* Writes all ML_TENSOR_RANK_LIMIT entries. */
ML_EXPORT int ml_tensors_info_get_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   ml_tensor_dimension dimension);
/* Size in bytes of tensor `index`, or of all tensors for an index below 0. A tensor without type or
 * dimensions counts as 0. */
ML_EXPORT int ml_tensors_info_get_tensor_size(ml_tensors_info_h info, int index, size_t* data_size);

/* Allocates zeroed memory for each tensor of a valid info, which is copied. */
ML_EXPORT int ml_tensors_data_create(const ml_tensors_info_h info, ml_tensors_data_h* data);
ML_EXPORT int ml_tensors_data_destroy(ml_tensors_data_h data);
/* Copies memory and info. The copy can be written. */
ML_EXPORT int ml_tensors_data_clone(const ml_tensors_data_h in, ml_tensors_data_h* out);
/* A new info of the tensors; free it with ml_tensors_info_destroy. */
ML_EXPORT int ml_tensors_data_get_info(const ml_tensors_data_h data, ml_tensors_info_h* info);
/* The memory of tensor `index`, valid until the data is destroyed. It is read-only for frames
 * passed to callbacks. */
ML_EXPORT int ml_tensors_data_get_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              void** raw_data, size_t* data_size);
/* Copies `raw_data` into the first `data_size` bytes of the tensor, 1 to its size.
 * ML_ERROR_PERMISSION_DENIED for read-only data. */
ML_EXPORT int ml_tensors_data_set_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              const void* raw_data, size_t data_size);

typedef void (*ml_data_destroy_cb)(void* data);
/* Options are values by name, for ml_single_open_with_option. */
ML_EXPORT int ml_option_create(ml_option_h* option);
/* Calls the destroy function of each value. */
ML_EXPORT int ml_option_destroy(ml_option_h option);
/* Keeps the pointer `value`. `destroy`, which may be NULL, is called with it when the option is
 * destroyed or the key is set again. */
ML_EXPORT int ml_option_set(ml_option_h option, const char* key, void* value,
                            ml_data_destroy_cb destroy);
ML_EXPORT int ml_option_get(ml_option_h option, const char* key, void** value);

/* No call of this library creates an information or a list: these calls check their arguments and
 * return ML_ERROR_INVALID_PARAMETER. */
ML_EXPORT int ml_information_get(ml_information_h information, const char* key, void** value);
ML_EXPORT int ml_information_destroy(ml_information_h information);
ML_EXPORT int ml_information_list_length(ml_information_list_h list, unsigned int* length);
ML_EXPORT int ml_information_list_get(ml_information_list_h list, unsigned int index,
                                      ml_information_h* information);
ML_EXPORT int ml_information_list_destroy(ml_information_list_h list);

#ifdef __cplusplus
}
#endif
#endif /* ML_API_COMMON_H */
