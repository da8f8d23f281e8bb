 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* What the calls of both headers share: errors, what tensors are (ml_tensors_info_*), the memory of
 * tensors (ml_tensors_data_*). C99. Included by nnstreamer.h and nnstreamer-single.h; link with
 * pkg-config capi-nnstreamer.
 *
 * Handles are numbers that are never given twice: each call tells NULL, a handle of another kind
 * and a handle that was destroyed from a good one, and answers ML_ERROR_INVALID_PARAMETER with the
 * words in ml_error(). Any thread may call.
 *
 * Functions return ML_ERROR_NONE or a value below 0. What a call gives through a pointer it gives
 * on success only; the pointer's target is NULL or 0 after a failure. */
#ifndef ML_TENSORS_H
#define ML_TENSORS_H
#include <errno.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef ML_EXPORT
#define ML_EXPORT __attribute__((visibility("default")))
#endif

/* In C++ any int is a value of these, as it is in C: what a caller gave can be looked at. */
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
  ML_ERROR_PERMISSION_DENIED = -EACCES, /* an element that [element-restriction] does not list */
  ML_ERROR_INVALID_PARAMETER = -EINVAL, /* a handle, name or value that cannot be used */
  ML_ERROR_OUT_OF_MEMORY = -ENOMEM,
  ML_ERROR_TIMED_OUT = -ETIMEDOUT,   /* ml_single_set_timeout */
  ML_ERROR_TRY_AGAIN = -EAGAIN,      /* not in this state, not from this callback */
  ML_ERROR_IO_ERROR = -EIO,          /* a file that is no model is not there or cannot be read */
  ML_ERROR_STREAMS_PIPE = -ESTRPIPE, /* an element of the pipeline has failed */
  ML_ERROR_NOT_SUPPORTED = -ENOTSUP, /* an engine or element that is not installed */
  ML_ERROR_UNKNOWN = -0x40000000     /* a fault inside; the words tell it */
} ml_error_e;

/* Why the last call of this thread that failed did: what, what was offered and needed, the first
 * difference, a line to paste; "" before there was one. Lives until this thread's next failure. */
ML_EXPORT const char* ml_error(void);
/* Its number, which docs/errors/WEIR-<number>.md explains; 0 before there was one. */
ML_EXPORT int ml_error_number(void);

#define ML_TENSOR_RANK_LIMIT (16)
#define ML_TENSOR_SIZE_LIMIT (256) /* tensors of a frame */
/* Innermost first; the entries from the rank on are 0. */
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

/* No tensor at first. */
ML_EXPORT int ml_tensors_info_create(ml_tensors_info_h* info);
ML_EXPORT int ml_tensors_info_destroy(ml_tensors_info_h info);
/* *valid: one tensor or more, each with a type and dimensions. */
ML_EXPORT int ml_tensors_info_validate(const ml_tensors_info_h info, bool* valid);
ML_EXPORT int ml_tensors_info_clone(ml_tensors_info_h dest, const ml_tensors_info_h src);
/* 1 to ML_TENSOR_SIZE_LIMIT; tensors that come get no type, dimensions or name, others stay. */
ML_EXPORT int ml_tensors_info_set_count(ml_tensors_info_h info, unsigned int count);
ML_EXPORT int ml_tensors_info_get_count(ml_tensors_info_h info, unsigned int* count);
/* `index` below the count. NULL as the name takes it away. */
ML_EXPORT int ml_tensors_info_set_tensor_name(ml_tensors_info_h info, unsigned int index,
                                              const char* name);
/* *name for free(); NULL where the tensor has none. */
ML_EXPORT int ml_tensors_info_get_tensor_name(ml_tensors_info_h info, unsigned int index,
                                              char** name);
ML_EXPORT int ml_tensors_info_set_tensor_type(ml_tensors_info_h info, unsigned int index,
                                              ml_tensor_type_e type);
ML_EXPORT int ml_tensors_info_get_tensor_type(ml_tensors_info_h info, unsigned int index,
                                              ml_tensor_type_e* type);
/* At least one entry that is not 0, and nothing behind the first 0. */
ML_EXPORT int ml_tensors_info_set_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   const ml_tensor_dimension dimension);
ML_EXPORT int ml_tensors_info_get_tensor_dimension(ml_tensors_info_h info, unsigned int index,
                                                   ml_tensor_dimension dimension);
/* Bytes of tensor `index`; index -1: of all. */
ML_EXPORT int ml_tensors_info_get_tensor_size(ml_tensors_info_h info, int index, size_t* data_size);

/* Memory for each tensor of an info that is valid, all 0. The info is copied. */
ML_EXPORT int ml_tensors_data_create(const ml_tensors_info_h info, ml_tensors_data_h* data);
ML_EXPORT int ml_tensors_data_destroy(ml_tensors_data_h data);
/* The memory of tensor `index`, which lives until the data is destroyed. Of outputs and of frames
 * that a callback gets it is to be read only. */
ML_EXPORT int ml_tensors_data_get_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              void** raw_data, size_t* data_size);
/* Copies the first `data_size` bytes of the tensor, 1 to its size. ML_ERROR_PERMISSION_DENIED for
 * data that is to be read only. */
ML_EXPORT int ml_tensors_data_set_tensor_data(ml_tensors_data_h data, unsigned int index,
                                              const void* raw_data, size_t data_size);

#ifdef __cplusplus
}
#endif
#endif /* ML_TENSORS_H */
