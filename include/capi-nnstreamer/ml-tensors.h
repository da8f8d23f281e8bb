/* Errors, tensor descriptions (ml_tensors_info_*) and tensor memory (ml_tensors_data_*), shared by
 * nnstreamer.h and nnstreamer-single.h, which include this header. C99; link with pkg-config
 * capi-nnstreamer.
 *
 * Handles are numbers that are never reused: every call detects NULL, handles of another kind and
 * destroyed handles, and returns ML_ERROR_INVALID_PARAMETER with the reason in ml_error(). Any
 * thread may call.
 *
 * Functions return ML_ERROR_NONE or a value below 0. Output pointers are set on success; after a
 * failure their target is NULL or 0.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef ML_TENSORS_H
#define ML_TENSORS_H
#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
  ML_ERROR_NONE = 0,
  ML_ERROR_PERMISSION_DENIED = -EACCES, /* an element missing from [element-restriction] */
  ML_ERROR_INVALID_PARAMETER = -EINVAL, /* an unusable handle, name or value */
  ML_ERROR_OUT_OF_MEMORY = -ENOMEM,
  ML_ERROR_TIMED_OUT = -ETIMEDOUT, /* see ml_single_set_timeout */
  ML_ERROR_TRY_AGAIN = -EAGAIN,    /* not in this state or not from this callback */
  ML_ERROR_IO_ERROR = -EIO,        /* a file other than a model does not exist or cannot be read */
  ML_ERROR_STREAMS_PIPE = -ESTRPIPE, /* an element of the pipeline has failed */
  ML_ERROR_NOT_SUPPORTED = -ENOTSUP, /* an engine or element is not installed */
  ML_ERROR_UNKNOWN = -0x40000000     /* internal error, described in ml_error() */
} ml_error_e;

/* The reason of this thread's last failed call: what failed, what was offered and needed, the first
 * difference, a line to paste; "" before the first failure. Valid until this thread's next
 * failure. */
ML_EXPORT const char* ml_error(void);
/* The error number, documented in docs/errors/WEIR-<number>.md; 0 before the first failure. */
ML_EXPORT int ml_error_number(void);

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

typedef void* ml_tensors_info_h;
typedef void* ml_tensors_data_h;

/* Creates an info without tensors. */
ML_EXPORT int ml_tensors_info_create(ml_tensors_info_h* info);
ML_EXPORT int ml_tensors_info_destroy(ml_tensors_info_h info);
/* *valid: at least one tensor, and each has a type and dimensions. */
ML_EXPORT int ml_tensors_info_validate(const ml_tensors_info_h info, bool* valid);
/* Replaces the content of `dest` with a deep copy of `src`. */
ML_EXPORT int ml_tensors_info_clone(ml_tensors_info_h dest, const ml_tensors_info_h src);
/* 1 to ML_TENSOR_SIZE_LIMIT. Added tensors have no type, dimensions or name. */
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
/* At least one entry that is not 0, and only zeros after the first 0. */
ML_EXPORT int ml_tensors_info_set_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   const ml_tensor_dimension dimension);
ML_EXPORT int ml_tensors_info_get_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   ml_tensor_dimension dimension);
/* Size in bytes of tensor `index`, or of all tensors for -1. */
ML_EXPORT int ml_tensors_info_get_tensor_size(ml_tensors_info_h info, int index, size_t* data_size);

/* Allocates zeroed memory for each tensor of a valid info, which is copied. */
ML_EXPORT int ml_tensors_data_create(const ml_tensors_info_h info, ml_tensors_data_h* data);
ML_EXPORT int ml_tensors_data_destroy(ml_tensors_data_h data);
/* The memory of tensor `index`, valid until the data is destroyed. It is read-only for outputs and
 * for frames passed to callbacks. */
ML_EXPORT int ml_tensors_data_get_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              void** raw_data, size_t* data_size);
/* Copies `raw_data` into the first `data_size` bytes of the tensor, 1 to its size.
 * ML_ERROR_PERMISSION_DENIED for read-only data. */
ML_EXPORT int ml_tensors_data_set_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              const void* raw_data, size_t data_size);

#ifdef __cplusplus
}
#endif
#endif /* ML_TENSORS_H */
