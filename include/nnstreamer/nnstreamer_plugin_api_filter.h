/* Filter sub-plugins: frameworks that run models for `tensor_filter framework=NAME`.
 *
 * A sub-plugin is a shared object libnnstreamer_filter_NAME.so whose constructor calls
 * nnstreamer_filter_probe() with a descriptor of version 0 or 1. Functions that return int return 0
 * or more on success, -ENOENT = not supported, -EINVAL = invalid arguments, other negative numbers
 * = failed; the invoke functions return > 0 to drop the frame. `priv` belongs to the sub-plugin,
 * one per element with an open model. Calls of one element do not overlap; several elements call
 * concurrently. Functions must not throw; an exception becomes an error of the element.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_PLUGIN_API_FILTER_H
#define NNSTREAMER_PLUGIN_API_FILTER_H
#include <errno.h>
#include <glib.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Values of `version`; the low 16 bits are free. */
#define GST_TENSOR_FILTER_FRAMEWORK_BASE (UINT64_C(0xDEAFDEAD00000000))
#define GST_TENSOR_FILTER_FRAMEWORK_V0 (GST_TENSOR_FILTER_FRAMEWORK_BASE)
#define GST_TENSOR_FILTER_FRAMEWORK_V1 (GST_TENSOR_FILTER_FRAMEWORK_BASE | UINT64_C(0x10000))
#define GST_TENSOR_FILTER_API_VERSION_DEFINED 1
#define GST_TENSOR_FILTER_API_VERSION_MIN 0
#define GST_TENSOR_FILTER_API_VERSION_MAX 1
/* Whether `value` is the `version` of a descriptor of API version 0 or 1. */
#define checkGstTensorFilterFrameworkVersion(value, version) \
  (((value) >> 16) == ((GST_TENSOR_FILTER_FRAMEWORK_BASE >> 16) | (uint64_t)(version)))

/* Names of accelerators, as get_accl_hw_type() reads them. */
#define ACCL_NONE_STR "none"
#define ACCL_AUTO_STR "auto"
#define ACCL_DEFAULT_STR "default"
#define ACCL_CPU_STR "cpu"
#define ACCL_CPU_SIMD_STR "cpu.simd"
#define ACCL_CPU_NEON_STR "cpu.neon"
#define ACCL_GPU_STR "gpu"
#define ACCL_NPU_STR "npu"
#define ACCL_NPU_MOVIDIUS_STR "npu.movidius"
#define ACCL_NPU_EDGE_TPU_STR "npu.edgetpu"
#define ACCL_NPU_VIVANTE_STR "npu.vivante"
#define ACCL_NPU_SRCN_STR "npu.srcn"
#define ACCL_NPU_SLSI_STR "npu.slsi"
#define ACCL_NPU_SR_STR "npu.sr"

/* With NO_ANONYMOUS_NESTED_STRUCT, the members of the two versions of a descriptor are in `v0` and
 * `v1`, as in `{ .version = ..., .v0 = { ... } }`. */
#ifdef NO_ANONYMOUS_NESTED_STRUCT
#define NNS_NESTED(name) name
#else
#define NNS_NESTED(name)
#endif

typedef struct _GstTensorFilterFramework GstTensorFilterFramework;

/* Statistics kept by a sub-plugin. Weir measures every invoke itself (latency=1, throughput=1) and
 * does not read these. Member names derived. */
typedef struct _GstTensorFilterFrameworkStatistics {
  int64_t total_invoke_num;
  int64_t total_invoke_latency;   /* microseconds */
  int64_t total_overhead_latency; /* microseconds outside the invokes */
} GstTensorFilterFrameworkStatistics;

/* Version 1: describes the framework. Strings and lists are borrowed and must stay valid. */
typedef struct _GstTensorFilterFrameworkInfo {
  const char* name;       /* framework=; "any" and "auto" are reserved */
  int allow_in_place;     /* outputs may share the memory of inputs */
  int allocate_in_invoke; /* invoke sets `data` of its outputs; DESTROY_NOTIFY frees them */
  int run_without_model;  /* model= is optional */
  int verify_model_path;  /* each part of model= must be a regular file */
  const accl_hw* hw_list;
  int num_hw;
  accl_hw accl_auto, accl_default; /* for accelerator=true, without accelerator= */
  const GstTensorFilterFrameworkStatistics* statistics;
} GstTensorFilterFrameworkInfo;

/* Operations of getModelInfo, version 1. */
typedef enum _model_info_ops {
  GET_IN_OUT_INFO = 0, /* fill in_info and out_info from the model */
  SET_INPUT_INFO = 1   /* fill out_info for the given in_info */
} model_info_ops;

typedef enum _event_ops {
  DESTROY_NOTIFY = 0,    /* free `data`, an output that invoke allocated */
  RELOAD_MODEL,          /* switch to model_files, num_models. Weir opens another model beside it
                            instead, and sends no *_PROP either */
  CUSTOM_PROP,           /* custom_properties changed */
  SET_INPUT_PROP,        /* info and layout of the inputs */
  SET_OUTPUT_PROP,       /* info and layout of the outputs */
  SET_ACCELERATOR,       /* hw_list and num_hw changed */
  CHECK_HW_AVAILABILITY, /* return 0 if `hw` is available for `custom`, or NULL */
  SUSPEND,               /* release what RESUME can restore */
  RESUME
} event_ops;

/* The data of an event: the members that its comment above names. */
typedef union _GstTensorFilterFrameworkEventData {
  void* data;
  __extension__ struct {
    const char** model_files;
    int num_models;
  };
  const char* custom_properties;
  __extension__ struct {
    const GstTensorsInfo* info;
    tensors_layout layout;
  };
  __extension__ struct {
    accl_hw* hw_list;
    int num_hw;
  };
  __extension__ struct {
    accl_hw hw;
    const char* custom;
  };
} GstTensorFilterFrameworkEventData;

/* A descriptor. It must stay valid until nnstreamer_filter_exit(). */
struct _GstTensorFilterFramework {
  uint64_t version;
  /* `*priv` is NULL on entry; the sub-plugin sets it. */
  int (*open)(const GstTensorFilterProperties* prop, void** priv);
  void (*close)(const GstTensorFilterProperties* prop, void** priv);

  __extension__ union {
    __extension__ struct { /* version 0: name and invoke_NN; the two getters or setInputDimension */
      char* name;
      int allow_in_place;
      int allocate_in_invoke;
      int run_without_model;
      int verify_model_path;
      const GstTensorFilterFrameworkStatistics* statistics;
      int (*invoke_NN)(const GstTensorFilterProperties* prop, void** priv,
                       const GstTensorMemory* input, GstTensorMemory* output);
      int (*getInputDimension)(const GstTensorFilterProperties* prop, void** priv,
                               GstTensorsInfo* info);
      int (*getOutputDimension)(const GstTensorFilterProperties* prop, void** priv,
                                GstTensorsInfo* info);
      int (*setInputDimension)(const GstTensorFilterProperties* prop, void** priv,
                               const GstTensorsInfo* in_info, GstTensorsInfo* out_info);
      void (*destroyNotify)(void** priv, void* data); /* NULL: g_free() */
      /* Not called: Weir opens another model beside the present one. */
      int (*reloadModel)(const GstTensorFilterProperties* prop, void** priv);
      int (*handleEvent)(event_ops op, GstTensorFilterFrameworkEventData* data);
      int (*checkAvailability)(accl_hw hw); /* 0 = available */
      int (*allocateInInvoke)(void** priv); /* 0 = this model does, if the flag is set */
    } NNS_NESTED(v0);
    __extension__ struct { /* version 1: all four */
      int (*invoke)(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop,
                    void* priv, const GstTensorMemory* input, GstTensorMemory* output);
      /* `priv` is NULL in queries about the framework itself. */
      int (*getFrameworkInfo)(const GstTensorFilterFramework* self,
                              const GstTensorFilterProperties* prop, void* priv,
                              GstTensorFilterFrameworkInfo* info);
      int (*getModelInfo)(const GstTensorFilterFramework* self,
                          const GstTensorFilterProperties* prop, void* priv, model_info_ops op,
                          GstTensorsInfo* in_info, GstTensorsInfo* out_info);
      int (*eventHandler)(const GstTensorFilterFramework* self,
                          const GstTensorFilterProperties* prop, void* priv, event_ops op,
                          GstTensorFilterFrameworkEventData* data);
      void* subplugin_data; /* for the sub-plugin, reached through self */
    } NNS_NESTED(v1);
  };
};
#undef NNS_NESTED

/* Registers a framework under its own name. TRUE, or FALSE with the reason in the log: a wrong
 * version, a missing function, a reserved or taken name. Thread-safe. */
NNS_EXPORT int nnstreamer_filter_probe(GstTensorFilterFramework* framework);
/* Releases the name. Elements with an open model continue to use the framework. */
NNS_EXPORT void nnstreamer_filter_exit(const char* name);
/* Finds a descriptor: a registered one, one from a file of that name (nnstreamer.ini), or one of
 * Weir's own frameworks by name or alias. NULL if there is none. */
NNS_EXPORT const GstTensorFilterFramework* nnstreamer_filter_find(const char* name);
/* The framework that framework=auto would choose for these files, without opening one; NULL if none
 * matches. `load_conf`: apply nnstreamer.ini. The caller frees it with g_free(). */
NNS_EXPORT gchar* gst_tensor_filter_detect_framework(const gchar* const* model_files,
                                                     const guint num, const gboolean load_conf);
/* TRUE if the framework supports `hw`. `custom` may be NULL; some frameworks need it. */
NNS_EXPORT gboolean gst_tensor_filter_check_hw_availability(const gchar* name, const accl_hw hw,
                                                            const gchar* custom);
/* Describes keys of custom= as pairs of key and text, NULL-terminated. Copied. */
NNS_EXPORT void nnstreamer_filter_set_custom_property_desc(const char* name, const char* key,
                                                           ...) NNS_SENTINEL;

/* Pushes one more output of a filter with invoke-async=true downstream, 0..N times per input, on
 * any thread. Takes over the bytes if the framework allocates in invoke, else copies them. With
 * invoke-dynamic, output_meta of `prop` describes them. */
NNS_EXPORT void nnstreamer_filter_dispatch_output_async(GstTensorFilterProperties* prop,
                                                        GstTensorMemory* output);

/* ---- Models that several elements share (shared-tensor-filter-key) ---- */

/* Returns the interpreter under `key` and adds `instance` to its users; NULL if there is none. */
NNS_EXPORT void* nnstreamer_filter_shared_model_get(void* instance, const char* key);
/* Stores `interpreter` unless there is one; returns the stored one, with `instance` as a user. */
NNS_EXPORT void* nnstreamer_filter_shared_model_insert_and_get(void* instance, const char* key,
                                                               void* interpreter);
/* Removes the user `instance`; for the last user, frees the interpreter with `free_callback`, which
 * may be NULL. FALSE if it is not a user. */
NNS_EXPORT int nnstreamer_filter_shared_model_remove(void* instance, const char* key,
                                                     void (*free_callback)(void* interpreter));
/* Replaces the interpreter for all users: calls `replace_callback` for each except `instance`, then
 * `free_callback` for the old interpreter. */
NNS_EXPORT void nnstreamer_filter_shared_model_replace(
    void* instance, const char* key, void* new_interpreter,
    void (*replace_callback)(void* instance, void* new_interpreter),
    void (*free_callback)(void* interpreter));

/* ---- Accelerators ---- */

/* The arguments of parse_accl_hw(). All but the first are optional and default to NULL. */
typedef struct _parse_accl_args {
  const char* in_accl;   /* accelerator=: "(true|false)[:list]"; NULL or "": not set */
  const char** sup_accl; /* supported names, NULL-terminated; NULL: all */
  const char* auto_accl; /* for true if none of the list is supported; NULL: the first supported */
  const char* def_accl;  /* if nothing is set */
} parse_accl_args;

/* Evaluates accelerator=, with the grammar of tensor_filter's property. */
NNS_EXPORT accl_hw parse_accl_hw_fill(parse_accl_args args);
/* The same as a function, for objects of earlier builds. */
NNS_EXPORT accl_hw parse_accl_hw(const char* accelerators, const char** supported_accelerators,
                                 const char* auto_accelerator, const char* default_accelerator);
#ifdef __cplusplus
#define NNS_ACCL_ARGS(in, sup, by_auto, by_default, ...) \
  (parse_accl_args{in, sup, by_auto, by_default})
#else
#define NNS_ACCL_ARGS(in, sup, by_auto, by_default, ...) \
  ((parse_accl_args){in, sup, by_auto, by_default})
#endif
#define parse_accl_hw(...) parse_accl_hw_fill(NNS_ACCL_ARGS(__VA_ARGS__, NULL, NULL, NULL, NULL))
/* Converts "cpu.simd" to its number; ACCL_NONE for an unknown name. */
NNS_EXPORT accl_hw get_accl_hw_type(const char* name);
/* Converts the number to its static name; "none" for an unknown number. */
NNS_EXPORT const char* get_accl_hw_str(accl_hw hw);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_FILTER_H */
