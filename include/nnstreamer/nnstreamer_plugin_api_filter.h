 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Filter sub-plugins: a framework that runs models for `tensor_filter framework=NAME`.
 *
 * A sub-plugin is a shared object libnnstreamer_filter_NAME.so whose constructor calls
 * nnstreamer_filter_probe() with a descriptor of version 0 or 1. Functions that return int give 0
 * or more when done; -ENOENT = not supported, -EINVAL = wrong arguments, another number below 0 =
 * failed; of the invokes, above 0 = nothing comes of this frame. `priv` is the sub-plugin's own,
 * one for each element that has a model open. Calls of one element do not overlap; several elements
 * call at once. Nothing may be thrown, though what is thrown ends as an error of the element. */
#ifndef NNSTREAMER_PLUGIN_API_FILTER_H
#define NNSTREAMER_PLUGIN_API_FILTER_H
#include <errno.h>
#include <glib.h>

#include "nnstreamer_util.h"
#include "tensor_typedef.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What `version` of a descriptor may be; its low 16 bits are free. */
#define GST_TENSOR_FILTER_FRAMEWORK_BASE (UINT64_C(0xDEAFDEAD00000000))
#define GST_TENSOR_FILTER_FRAMEWORK_V0 (GST_TENSOR_FILTER_FRAMEWORK_BASE)
#define GST_TENSOR_FILTER_FRAMEWORK_V1 (GST_TENSOR_FILTER_FRAMEWORK_BASE | UINT64_C(0x10000))

typedef struct _GstTensorFilterFramework GstTensorFilterFramework;

/* A sub-plugin's own count of its work. Weir measures every invoke itself (latency=1, throughput=1)
 * and reads nothing through a descriptor's pointer. Members' names derived. */
typedef struct _GstTensorFilterFrameworkStatistics {
  int64_t total_invoke_num;
  int64_t total_invoke_latency;   /* microseconds */
  int64_t total_overhead_latency; /* microseconds, of what is around the invokes */
} GstTensorFilterFrameworkStatistics;

/* Version 1: what the framework is. Strings and lists stay the sub-plugin's and must stay. */
typedef struct _GstTensorFilterFrameworkInfo {
  const char* name;       /* of framework=; "any" and "auto" are reserved */
  int allow_in_place;     /* outputs may be the memory of inputs */
  int allocate_in_invoke; /* invoke sets `data` of its outputs; DESTROY_NOTIFY frees them */
  int run_without_model;  /* model= may be left out */
  int verify_model_path;  /* each part of model= must be a regular file */
  const accl_hw* hw_list;
  int num_hw;
  accl_hw accl_auto, accl_default; /* of accelerator=true, of no accelerator= */
  const GstTensorFilterFrameworkStatistics* statistics;
} GstTensorFilterFrameworkInfo;

/* What getModelInfo of version 1 is asked for. */
typedef enum _model_info_ops {
  GET_IN_OUT_INFO = 0, /* fill in_info and out_info: the model's own */
  SET_INPUT_INFO = 1   /* in_info is given: fill out_info */
} model_info_ops;

typedef enum _event_ops {
  DESTROY_NOTIFY = 0,    /* free `data`, an output that invoke allocated */
  RELOAD_MODEL,          /* model_files and num_models: go on with that model. Weir opens another
                            one beside it instead, and so sends no *_PROP either */
  CUSTOM_PROP,           /* custom_properties changed */
  SET_INPUT_PROP,        /* info and layout: of the inputs */
  SET_OUTPUT_PROP,       /* info and layout: of the outputs */
  SET_ACCELERATOR,       /* hw_list and num_hw changed */
  CHECK_HW_AVAILABILITY, /* 0 when `hw` is there for `custom`, which may be NULL */
  SUSPEND,               /* give back what RESUME can bring again */
  RESUME
} event_ops;

/* The data of an event: the members that its line above names. */
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

/* A descriptor. It must stay until nnstreamer_filter_exit(). */
struct _GstTensorFilterFramework {
  uint64_t version;
  /* `*priv` comes as NULL and is the sub-plugin's. */
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
      /* Weir opens another model beside the present one and does not call this. */
      int (*reloadModel)(const GstTensorFilterProperties* prop, void** priv);
      int (*handleEvent)(event_ops op, GstTensorFilterFrameworkEventData* data);
      int (*checkAvailability)(accl_hw hw); /* 0 = there */
      int (*allocateInInvoke)(void** priv); /* 0 = this model does, where the flag is set */
    };
    __extension__ struct { /* version 1: all four */
      int (*invoke)(const GstTensorFilterFramework* self, GstTensorFilterProperties* prop,
                    void* priv, const GstTensorMemory* input, GstTensorMemory* output);
      /* `priv` is NULL when the framework itself is asked about. */
      int (*getFrameworkInfo)(const GstTensorFilterFramework* self,
                              const GstTensorFilterProperties* prop, void* priv,
                              GstTensorFilterFrameworkInfo* info);
      int (*getModelInfo)(const GstTensorFilterFramework* self,
                          const GstTensorFilterProperties* prop, void* priv, model_info_ops op,
                          GstTensorsInfo* in_info, GstTensorsInfo* out_info);
      int (*eventHandler)(const GstTensorFilterFramework* self,
                          const GstTensorFilterProperties* prop, void* priv, event_ops op,
                          GstTensorFilterFrameworkEventData* data);
      void* subplugin_data; /* the sub-plugin's, found through self */
    };
  };
};

/* Registers a framework under the name that it gives. TRUE, or FALSE with the reason in the log: a
 * wrong version, a missing function, a name that is reserved or taken. Thread-safe. */
NNS_EXPORT int nnstreamer_filter_probe(GstTensorFilterFramework* framework);
/* Frees the name. Elements that have a model open go on with the framework. */
NNS_EXPORT void nnstreamer_filter_exit(const char* name);
/* The descriptor: a registered one, one from a file of that name (nnstreamer.ini), or one of Weir's
 * own frameworks by name or alias. NULL when there is none of this name. */
NNS_EXPORT const GstTensorFilterFramework* nnstreamer_filter_find(const char* name);
/* What framework=auto takes for these files, without opening one; NULL when nothing claims them.
 * `load_conf`: nnstreamer.ini has its say. The caller's: g_free(). */
NNS_EXPORT gchar* gst_tensor_filter_detect_framework(const gchar* const* model_files,
                                                     const guint num, const gboolean load_conf);
/* Whether the framework runs on `hw`. `custom`, which may be NULL, is for those that ask for it. */
NNS_EXPORT gboolean gst_tensor_filter_check_hw_availability(const gchar* name, const accl_hw hw,
                                                            const gchar* custom);
/* Describes keys of custom=: pairs of key and text, ended with NULL. Copied. */
NNS_EXPORT void nnstreamer_filter_set_custom_property_desc(const char* name, const char* key,
                                                           ...) NNS_SENTINEL;

/* Hands one more output of a filter with invoke-async=true downstream, from any thread, 0..N times
 * for an input. The bytes are taken over where the framework allocates in invoke, else copied.
 * With invoke-dynamic, output_meta of `prop` says what they are. */
NNS_EXPORT void nnstreamer_filter_dispatch_output_async(GstTensorFilterProperties* prop,
                                                        GstTensorMemory* output);

/* ---- Models that several elements share (shared-tensor-filter-key) ---- */

/* The interpreter under `key`, of which `instance` is a user from now on; NULL when there is none.
 */
NNS_EXPORT void* nnstreamer_filter_shared_model_get(void* instance, const char* key);
/* Puts it there unless there is one; returns the one that is there, with `instance` as a user. */
NNS_EXPORT void* nnstreamer_filter_shared_model_insert_and_get(void* instance, const char* key,
                                                               void* interpreter);
/* `instance` uses it no more; the last user's call frees it with `free_callback`, which may be
 * NULL. FALSE when it is no user. */
NNS_EXPORT int nnstreamer_filter_shared_model_remove(void* instance, const char* key,
                                                     void (*free_callback)(void* interpreter));
/* Another interpreter for all users: `replace_callback` is called for each one but `instance`,
 * then `free_callback` for the old one. */
NNS_EXPORT void nnstreamer_filter_shared_model_replace(
    void* instance, const char* key, void* new_interpreter,
    void (*replace_callback)(void* instance, void* new_interpreter),
    void (*free_callback)(void* interpreter));

/* ---- Accelerators ---- */

/* The arguments of parse_accl_hw(). All but the first are optional there and NULL by default. */
typedef struct _parse_accl_args {
  const char* in_accl;   /* accelerator=: "(true|false)[:list]"; NULL or "": not set */
  const char** sup_accl; /* names that are supported, ended with NULL; NULL: all of them */
  const char* auto_accl; /* chosen for true without a listed one that is supported; NULL: the first
                            that is supported */
  const char* def_accl;  /* chosen where nothing is set */
} parse_accl_args;

/* What accelerator= comes to (the grammar is that of tensor_filter's property). */
NNS_EXPORT accl_hw parse_accl_hw_fill(parse_accl_args args);
/* The same as a function, which objects of earlier builds call. */
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
/* "cpu.simd" to its number; ACCL_NONE for what is no name. */
NNS_EXPORT accl_hw get_accl_hw_type(const char* name);
/* And back; static, "none" for what is no number of one. */
NNS_EXPORT const char* get_accl_hw_str(accl_hw hw);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_PLUGIN_API_FILTER_H */
