 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* Pipelines of a program: ml_pipeline_*. C99; pkg-config capi-nnstreamer. What stands behind it is
 * weir/pipeline.h, and docs/guide/from-nnstreamer.md says what is there.
 *
 * Callbacks are called on threads of the stream. They may call everything here but what changes the
 * state of their own pipeline: start, stop, flush and destroy are ML_ERROR_TRY_AGAIN there, which
 * would wait for themselves. Handles that a callback gets are good until it returns. */
#ifndef NNSTREAMER_H
#define NNSTREAMER_H
#include "ml-tensors.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef void* ml_pipeline_h;
typedef void* ml_pipeline_sink_h;
typedef void* ml_pipeline_src_h;
typedef void* ml_pipeline_switch_h;
typedef void* ml_pipeline_valve_h;
typedef void* ml_pipeline_element_h;
typedef void* ml_custom_easy_filter_h;
typedef void* ml_pipeline_if_h;

/* Numbers of GStreamer's states. READY is told as NULL. */
typedef enum ML_ANY_INT {
  ML_PIPELINE_STATE_UNKNOWN = 0,
  ML_PIPELINE_STATE_NULL = 1,
  ML_PIPELINE_STATE_READY = 2,
  ML_PIPELINE_STATE_PAUSED = 3,
  ML_PIPELINE_STATE_PLAYING = 4
} ml_pipeline_state_e;

/* Each time the whole pipeline has another state. */
typedef void (*ml_pipeline_state_cb)(ml_pipeline_state_e state, void* user_data);

/* From a text as gst-launch-1.0 takes it. ML_ERROR_PERMISSION_DENIED for an element that the
 * configuration ([element-restriction]) does not allow. `cb` may be NULL; `user_data` must live
 * until destroy has returned. */
ML_EXPORT int ml_pipeline_construct(const char* pipeline_description, ml_pipeline_state_cb cb,
                                    void* user_data, ml_pipeline_h* pipe);
/* Stops, waits for callbacks that run, and frees. Handles of its parts stay to be released. */
ML_EXPORT int ml_pipeline_destroy(ml_pipeline_h pipe);
/* Returns before the first frame has come through. What an element reports later is the error of
 * ml_pipeline_get_state and of every other call, until ml_pipeline_flush. */
ML_EXPORT int ml_pipeline_start(ml_pipeline_h pipe);
/* Pauses: what is inside stays, and start goes on. */
ML_EXPORT int ml_pipeline_stop(ml_pipeline_h pipe);
/* Where it is, or where it is on its way to. ML_ERROR_STREAMS_PIPE when an element has failed; the
 * state is given then too. */
ML_EXPORT int ml_pipeline_get_state(ml_pipeline_h pipe, ml_pipeline_state_e* state);
/* Throws away what is inside, and an error with it; then starts it again, or leaves it in
 * ML_PIPELINE_STATE_NULL. */
ML_EXPORT int ml_pipeline_flush(ml_pipeline_h pipe, bool start);

/* A frame of a tensor_sink or appsink; media are one uint8 tensor. `data` is to be read only. */
typedef void (*ml_pipeline_sink_cb)(const ml_tensors_data_h data, const ml_tensors_info_h info,
                                    void* user_data);
/* `sink_name`: its name= in the text. Several callbacks of one sink are called one after the
 * other. Frames that come while none is registered are gone. */
ML_EXPORT int ml_pipeline_sink_register(ml_pipeline_h pipe, const char* sink_name,
                                        ml_pipeline_sink_cb cb, void* user_data,
                                        ml_pipeline_sink_h* sink_handle);
/* Waits for the callback where another thread is in it; it is not called again. */
ML_EXPORT int ml_pipeline_sink_unregister(ml_pipeline_sink_h sink_handle);

typedef enum ML_ANY_INT {
  ML_PIPELINE_BUF_POLICY_AUTO_FREE = 0, /* the data is destroyed when it was taken */
  ML_PIPELINE_BUF_POLICY_DO_NOT_FREE = 1
} ml_pipeline_buf_policy_e;

/* Of an appsrc. */
ML_EXPORT int ml_pipeline_src_get_handle(ml_pipeline_h pipe, const char* src_name,
                                         ml_pipeline_src_h* src_handle);
ML_EXPORT int ml_pipeline_src_release_handle(ml_pipeline_src_h src_handle);
/* Bytes are copied. The data is held against the caps of the appsrc; where it has none they are
 * written from the data's info. ML_ERROR_TRY_AGAIN before start, and behind the end. */
ML_EXPORT int ml_pipeline_src_input_data(ml_pipeline_src_h src_handle, ml_tensors_data_h data,
                                         ml_pipeline_buf_policy_e policy);
ML_EXPORT int ml_pipeline_src_input_data_eos(ml_pipeline_src_h src_handle);

typedef enum ML_ANY_INT {
  ML_PIPELINE_SWITCH_OUTPUT_SELECTOR = 0,
  ML_PIPELINE_SWITCH_INPUT_SELECTOR = 1
} ml_pipeline_switch_e;

/* Of an input-selector or output-selector. `type` may be NULL. */
ML_EXPORT int ml_pipeline_switch_get_handle(ml_pipeline_h pipe, const char* switch_name,
                                            ml_pipeline_switch_e* type,
                                            ml_pipeline_switch_h* switch_handle);
ML_EXPORT int ml_pipeline_switch_release_handle(ml_pipeline_switch_h switch_handle);
ML_EXPORT int ml_pipeline_switch_select(ml_pipeline_switch_h switch_handle, const char* pad_name);
/* Pads that can be selected: a list with NULL at its end; free() each and the list. */
ML_EXPORT int ml_pipeline_switch_get_pad_list(ml_pipeline_switch_h switch_handle, char*** list);

/* Of a valve. Open: frames pass. */
ML_EXPORT int ml_pipeline_valve_get_handle(ml_pipeline_h pipe, const char* valve_name,
                                           ml_pipeline_valve_h* valve_handle);
ML_EXPORT int ml_pipeline_valve_release_handle(ml_pipeline_valve_h valve_handle);
ML_EXPORT int ml_pipeline_valve_set_open(ml_pipeline_valve_h valve_handle, bool open);

/* Of any element, and its properties. A property of another type than the call's is
 * ML_ERROR_INVALID_PARAMETER. Strings that are given are for free(). */
ML_EXPORT int ml_pipeline_element_get_handle(ml_pipeline_h pipe, const char* element_name,
                                             ml_pipeline_element_h* elem_h);
ML_EXPORT int ml_pipeline_element_release_handle(ml_pipeline_element_h elem_h);
ML_EXPORT int ml_pipeline_element_set_property_bool(ml_pipeline_element_h elem_h,
                                                    const char* property_name, const int32_t value);
ML_EXPORT int ml_pipeline_element_set_property_string(ml_pipeline_element_h elem_h,
                                                      const char* property_name, const char* value);
ML_EXPORT int ml_pipeline_element_set_property_int32(ml_pipeline_element_h elem_h,
                                                     const char* property_name,
                                                     const int32_t value);
ML_EXPORT int ml_pipeline_element_set_property_int64(ml_pipeline_element_h elem_h,
                                                     const char* property_name,
                                                     const int64_t value);
ML_EXPORT int ml_pipeline_element_set_property_uint32(ml_pipeline_element_h elem_h,
                                                      const char* property_name,
                                                      const uint32_t value);
ML_EXPORT int ml_pipeline_element_set_property_uint64(ml_pipeline_element_h elem_h,
                                                      const char* property_name,
                                                      const uint64_t value);
ML_EXPORT int ml_pipeline_element_set_property_double(ml_pipeline_element_h elem_h,
                                                      const char* property_name,
                                                      const double value);
ML_EXPORT int ml_pipeline_element_set_property_enum(ml_pipeline_element_h elem_h,
                                                    const char* property_name,
                                                    const uint32_t value);
ML_EXPORT int ml_pipeline_element_get_property_bool(ml_pipeline_element_h elem_h,
                                                    const char* property_name, int32_t* value);
ML_EXPORT int ml_pipeline_element_get_property_string(ml_pipeline_element_h elem_h,
                                                      const char* property_name, char** value);
ML_EXPORT int ml_pipeline_element_get_property_int32(ml_pipeline_element_h elem_h,
                                                     const char* property_name, int32_t* value);
ML_EXPORT int ml_pipeline_element_get_property_int64(ml_pipeline_element_h elem_h,
                                                     const char* property_name, int64_t* value);
ML_EXPORT int ml_pipeline_element_get_property_uint32(ml_pipeline_element_h elem_h,
                                                      const char* property_name, uint32_t* value);
ML_EXPORT int ml_pipeline_element_get_property_uint64(ml_pipeline_element_h elem_h,
                                                      const char* property_name, uint64_t* value);
ML_EXPORT int ml_pipeline_element_get_property_double(ml_pipeline_element_h elem_h,
                                                      const char* property_name, double* value);
ML_EXPORT int ml_pipeline_element_get_property_enum(ml_pipeline_element_h elem_h,
                                                    const char* property_name, uint32_t* value);

/* A model of `tensor_filter framework=custom-easy model=NAME`, and of ml_single_open: fills `out`.
 * Returns 0; above 0 to drop the frame; below 0: the stream ends with an error. */
typedef int (*ml_custom_easy_invoke_cb)(const ml_tensors_data_h in, ml_tensors_data_h out,
                                        void* user_data);
/* Of one thread at a time. */
ML_EXPORT int ml_pipeline_custom_easy_filter_register(const char* name, const ml_tensors_info_h in,
                                                      const ml_tensors_info_h out,
                                                      ml_custom_easy_invoke_cb cb, void* user_data,
                                                      ml_custom_easy_filter_h* custom);
/* Waits for the callback where another thread is in it; streams that still have the filter end with
 * an error. */
ML_EXPORT int ml_pipeline_custom_easy_filter_unregister(ml_custom_easy_filter_h custom);

/* The condition of `tensor_if compared-value=CUSTOM compared-value-option=NAME`: sets *result to 0
 * for the ELSE branch, else THEN. Returns 0; above 0 to drop the frame; below 0: an error. */
typedef int (*ml_pipeline_if_custom_cb)(const ml_tensors_data_h data, const ml_tensors_info_h info,
                                        int* result, void* user_data);
ML_EXPORT int ml_pipeline_tensor_if_custom_register(const char* name, ml_pipeline_if_custom_cb cb,
                                                    void* user_data, ml_pipeline_if_h* if_custom);
ML_EXPORT int ml_pipeline_tensor_if_custom_unregister(ml_pipeline_if_h if_custom);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_H */
