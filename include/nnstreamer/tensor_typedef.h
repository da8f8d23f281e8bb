/* Types that sub-plugins and custom filters share with the host: element types, dimensions,
 * tensors, and the properties of a filter's element.
 *
 * Sizes and order of all members are binary interface (LP64) and never change. Dimensions are
 * innermost first: dimension[0] varies fastest; entries beyond the rank are 0. Unless documented
 * otherwise, strings and arrays belong to the caller and are valid for the call. Plain C99 and
 * C++11; needs no GLib.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_TENSOR_TYPEDEF_H
#define NNSTREAMER_TENSOR_TYPEDEF_H
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* In C++ these enums accept any int, as in C, so that values from callbacks can be checked. */
#ifdef __cplusplus
#define NNS_ANY_INT : int
#else
#define NNS_ANY_INT
#endif

#define NNS_TENSOR_RANK_LIMIT 16        /* dimensions of a tensor */
#define NNS_TENSOR_SIZE_LIMIT 256       /* tensors of a frame */
#define NNS_TENSOR_MEMORY_MAX 16        /* memories of a buffer; the last one packs the rest */
#define NNS_TENSOR_SIZE_EXTRA_LIMIT 240 /* tensors beyond the array in GstTensorsInfo */

/* Caps of tensor streams and parts of them, as string literals to join. */
#define NNS_MIMETYPE_TENSOR "other/tensor"
#define NNS_MIMETYPE_TENSORS "other/tensors"
#define NNS_TENSOR_SIZE_LIMIT_STR "256"
#define GST_TENSOR_NUM_TENSORS_RANGE "(int) [ 1, " NNS_TENSOR_SIZE_LIMIT_STR " ]"
#define GST_TENSOR_RATE_RANGE "(fraction) [ 0, max ]"
#define GST_TENSOR_TYPE_ALL \
  "{ int32, uint32, int16, uint16, int8, uint8, float64, float32, int64, uint64, float16 }"
#define GST_TENSOR_FORMAT_ALL "{ static, flexible, sparse }"
#define GST_TENSOR_CAP_DEFAULT NNS_MIMETYPE_TENSOR ", framerate = " GST_TENSOR_RATE_RANGE
#define GST_TENSORS_CAP_MAKE(fmt) \
  NNS_MIMETYPE_TENSORS ", format = " fmt ", framerate = " GST_TENSOR_RATE_RANGE
#define GST_TENSORS_CAP_WITH_NUM(num) GST_TENSORS_CAP_MAKE("static, num_tensors = " num)
#define GST_TENSORS_CAP_DEFAULT GST_TENSORS_CAP_WITH_NUM(GST_TENSOR_NUM_TENSORS_RANGE)
#define GST_TENSORS_FLEX_CAP_DEFAULT GST_TENSORS_CAP_MAKE("flexible")
#define GST_TENSORS_SPARSE_CAP_DEFAULT GST_TENSORS_CAP_MAKE("sparse")

/* The type of an element. The numbers are part of wire formats. */
typedef enum _tensor_type NNS_ANY_INT {
  _NNS_INT32 = 0,
  _NNS_UINT32,
  _NNS_INT16,
  _NNS_UINT16,
  _NNS_INT8,
  _NNS_UINT8,
  _NNS_FLOAT64,
  _NNS_FLOAT32,
  _NNS_INT64,
  _NNS_UINT64,
  _NNS_FLOAT16,
  _NNS_END /* no type */
} tensor_type;

/* One element of any type. */
typedef union _tensor_element {
  int32_t _int32_t;
  uint32_t _uint32_t;
  int16_t _int16_t;
  uint16_t _uint16_t;
  int8_t _int8_t;
  uint8_t _uint8_t;
  double _double;
  float _float;
  int64_t _int64_t;
  uint64_t _uint64_t;
} tensor_element;

/* The layout of a stream's frames: one size for all; a header of 128 bytes before each tensor; the
 * same with only the elements that are not 0. */
typedef enum _tensor_format NNS_ANY_INT {
  _NNS_TENSOR_FORMAT_STATIC = 0,
  _NNS_TENSOR_FORMAT_FLEXIBLE,
  _NNS_TENSOR_FORMAT_SPARSE,
  _NNS_TENSOR_FORMAT_END
} tensor_format;

/* The original medium of a stream; kept in the header of flexible tensors. */
typedef enum _nns_media_type NNS_ANY_INT {
  _NNS_MEDIA_INVALID = -1,
  _NNS_VIDEO = 0,
  _NNS_AUDIO,
  _NNS_TEXT,
  _NNS_OCTET,
  _NNS_TENSOR,
  _NNS_MEDIA_ANY = 0x1000
} media_type;

/* The order of the dimensions of pictures. Weir passes on the user's value and moves no data. */
typedef enum _tensor_layout NNS_ANY_INT {
  _NNS_LAYOUT_ANY = 0,
  _NNS_LAYOUT_NHWC,
  _NNS_LAYOUT_NCHW,
  _NNS_LAYOUT_NONE
} tensor_layout;

typedef uint32_t tensor_dim[NNS_TENSOR_RANK_LIMIT];

/* Accelerators. The numbers are binary interface; the names are the values of the property
 * `accelerator` in capitals. */
typedef enum _accl_hw NNS_ANY_INT {
  ACCL_NONE = 0,
  ACCL_AUTO = 1,
  ACCL_DEFAULT = 2,
  ACCL_CPU = 0x1000,
  ACCL_CPU_SIMD = 0x1100,
  ACCL_CPU_NEON = 0x1100,
  ACCL_GPU = 0x2000,
  ACCL_NPU = 0x4000,
  ACCL_NPU_MOVIDIUS = 0x4001,
  ACCL_NPU_EDGETPU = 0x4002,
  ACCL_NPU_VIVANTE = 0x4003,
  ACCL_NPU_SRCN = 0x4004,
  ACCL_NPU_SLSI = 0x4005,
  ACCL_NPU_SR = 0x4100
} accl_hw;

/* One tensor's description. `name` may be NULL; in structs that a program frees with
 * gst_tensor_info_free() it is g_malloc'ed. A dimension whose first entry is 0 is not set. */
typedef struct _GstTensorInfo {
  char* name;
  tensor_type type;
  tensor_dim dimension;
} GstTensorInfo;

/* The tensors of a frame: the first 16 in `info`, the others in `extra`, which has 240 entries if
 * allocated. gst_tensors_info_get_nth_info() hides the difference and allocates `extra` on
 * demand. */
typedef struct _GstTensorsInfo {
  unsigned int num_tensors;
  GstTensorInfo info[NNS_TENSOR_MEMORY_MAX];
  GstTensorInfo* extra;
  tensor_format format;
} GstTensorsInfo;

/* A stream: its tensors and its frame rate. A denominator of 0 or below means no valid rate. */
typedef struct _GstTensorsConfig {
  GstTensorsInfo info;
  int rate_n, rate_d;
} GstTensorsConfig;

/* One tensor's bytes. Inputs are read-only. */
typedef struct _GstTensorMemory {
  void* data;
  size_t size; /* bytes */
} GstTensorMemory;

typedef struct _GstSparseTensorInfo {
  uint32_t nnz; /* number of elements that are not 0 */
} GstSparseTensorInfo;

/* The header of a flexible or sparse tensor as 32-bit words; gst_tensor_meta_info_*() reads and
 * writes it. In the stream these 22 words are followed by 42 words of 0: do not cast, use
 * gst_tensor_meta_info_parse_header(). Members derived from the words of the wire format. */
typedef struct _GstTensorMetaInfo {
  uint32_t magic;   /* 0xfeedcced */
  uint32_t version; /* 0xDE000000 | major << 12 | minor */
  uint32_t type;    /* tensor_type */
  tensor_dim dimension;
  uint32_t format;     /* tensor_format */
  uint32_t media_type; /* media_type */
  __extension__ union { GstSparseTensorInfo sparse_info; };
} GstTensorMetaInfo;

typedef tensor_layout tensors_layout[NNS_TENSOR_SIZE_LIMIT];

/* Receives one output of an asynchronous filter, of all its tensors; see
 * nnstreamer_filter_dispatch_output_async(). Returns 0, or below 0 on failure. */
typedef int (*GstTensorDataCallback)(GstTensorMemory* data, GstTensorsInfo* info, void* user_data);

/* Properties of a filter's element: the user's settings, and the tensors of the stream as far as
 * they are known. Owned by the host, constant during a call. Flags are 0 or 1. */
typedef struct _GstTensorFilterProperties {
  const char* fwname; /* of the framework */
  int fw_opened;
  const char** model_files;
  int num_models;

  int input_configured; /* input_meta describes the stream */
  GstTensorsInfo input_meta;
  tensors_layout input_layout;
  unsigned int input_ranks[NNS_TENSOR_SIZE_LIMIT];

  int output_configured;
  GstTensorsInfo output_meta;
  tensors_layout output_layout;
  unsigned int output_ranks[NNS_TENSOR_SIZE_LIMIT];

  const char* custom_properties; /* custom=, or NULL */
  accl_hw* hw_list;              /* parsed from the user's accelerator= */
  int num_hw;
  const char* accl_str; /* accelerator= as written, or NULL */
  char* shared_tensor_filter_key;

  int latency, throughput; /* 1 if the user measures it */
  int invoke_dynamic;
  uint32_t suspend; /* ms, 0 = never */

  int invoke_async;
  GstTensorDataCallback async_callback;
  void* async_user_data;
} GstTensorFilterProperties;

#undef NNS_ANY_INT
#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_TENSOR_TYPEDEF_H */
