/* Pipelines for programs: ml_pipeline_*. C99; pkg-config capi-ml-inference. Implemented with
 * weir/pipeline.h; docs/guide/from-nnstreamer.md lists the coverage.
 *
 * Callbacks run on streaming threads. They may call every function except those that change the
 * state of their own pipeline: start, stop, flush and destroy return ML_ERROR_TRY_AGAIN there,
 * since they would wait for themselves. Handles passed to a callback are valid until it returns.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_H
#define NNSTREAMER_H
#include "ml-api-common.h"

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

/* Words of pipelines for Tizen, which replaces them by its camera; unknown elements elsewhere. */
#define ML_TIZEN_CAM_VIDEO_SRC "tizencamvideosrc"
#define ML_TIZEN_CAM_AUDIO_SRC "tizencamaudiosrc"

/* *available: GStreamer knows an element of this name, and the configuration allows it. */
ML_EXPORT int ml_check_element_availability(const char* element_name, bool* available);
/* *available: the engine is installed and runs on this hardware. ML_ERROR_INVALID_PARAMETER for
 * ML_NNFW_TYPE_ANY. */
ML_EXPORT int ml_check_nnfw_availability(ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw, bool* available);
ML_EXPORT int ml_check_nnfw_availability_full(ml_nnfw_type_e nnfw, ml_nnfw_hw_e hw,
                                              const char* custom_option, bool* available);

/* GStreamer's states. */
typedef enum ML_ANY_INT {
  ML_PIPELINE_STATE_UNKNOWN = 0,
  ML_PIPELINE_STATE_NULL = 1,
  ML_PIPELINE_STATE_READY = 2,
  ML_PIPELINE_STATE_PAUSED = 3,
  ML_PIPELINE_STATE_PLAYING = 4
} ml_pipeline_state_e;

/* Called after each state change of the whole pipeline. */
typedef void (*ml_pipeline_state_cb)(ml_pipeline_state_e state, void* user_data);

/* Parses text of gst-launch-1.0 and pauses the pipeline. ML_ERROR_STREAMS_PIPE, and NULL in *pipe,
 * for a text that does not parse and for elements that cannot be paused, such as a model that does
 * not exist; ML_ERROR_NOT_SUPPORTED for an element that the configuration ([element-restriction])
 * does not allow. `cb` may be NULL; `user_data` must stay valid until destroy has returned. */
ML_EXPORT int ml_pipeline_construct(const char* pipeline_description, ml_pipeline_state_cb cb,
                                    void* user_data, ml_pipeline_h* pipe);
/* Stops the pipeline, waits for running callbacks and frees it with the handles of its parts. */
ML_EXPORT int ml_pipeline_destroy(ml_pipeline_h pipe);
/* Returns before the first frame is through. After an element has posted an error, calls of the
 * pipeline and of its sources return ML_ERROR_STREAMS_PIPE until ml_pipeline_flush. */
ML_EXPORT int ml_pipeline_start(ml_pipeline_h pipe);
/* Pauses: frames in the pipeline are kept, and start resumes. */
ML_EXPORT int ml_pipeline_stop(ml_pipeline_h pipe);
/* The current state: READY until the first frames have arrived at the sinks. ML_ERROR_STREAMS_PIPE
 * when an element has failed; *state is set in that case as well. */
ML_EXPORT int ml_pipeline_get_state(ml_pipeline_h pipe, ml_pipeline_state_e* state);
/* Pauses, discards the frames in the pipeline and any error, and starts it again if `start`. Goes
 * through NULL only if the stream has failed or ended. */
ML_EXPORT int ml_pipeline_flush(ml_pipeline_h pipe, bool start);

/* A frame of a tensor_sink or appsink; media are one uint8 tensor. `data` is read-only. */
typedef void (*ml_pipeline_sink_cb)(const ml_tensors_data_h data, const ml_tensors_info_h info,
                                    void* user_data);
/* `sink_name`: its name= in the text. Callbacks of one sink are called one after the other. Frames
 * that arrive while none is registered, or do not match static caps, are dropped. */
ML_EXPORT int ml_pipeline_sink_register(ml_pipeline_h pipe, const char* sink_name,
                                        ml_pipeline_sink_cb cb, void* user_data,
                                        ml_pipeline_sink_h* sink_handle);
/* Waits for a callback running on another thread; it is not called again. */
ML_EXPORT int ml_pipeline_sink_unregister(ml_pipeline_sink_h sink_handle);

typedef enum ML_ANY_INT {
  ML_PIPELINE_BUF_POLICY_AUTO_FREE = 0, /* destroys the data once it is pushed */
  ML_PIPELINE_BUF_POLICY_DO_NOT_FREE = 1,
  ML_PIPELINE_BUF_POLICY_MAX = 2,         /* not a policy */
  ML_PIPELINE_BUF_SRC_EVENT_EOS = 0x10000 /* ends the stream; the data is not looked at */
} ml_pipeline_buf_policy_e;

/* Finds the appsrc `src_name`. */
ML_EXPORT int ml_pipeline_src_get_handle(ml_pipeline_h pipe, const char* src_name,
                                         ml_pipeline_src_h* src_handle);
/* Waits for a function of ml_pipeline_src_set_event_cb that runs on another thread. */
ML_EXPORT int ml_pipeline_src_release_handle(ml_pipeline_src_h src_handle);
/* Copies the bytes. The data must have the number of tensors and the sizes of the appsrc's caps, or
 * of those after it (a capsfilter); types are not compared. Media take any tensors with the bytes
 * of a frame. An appsrc without such caps takes them from the data's info. ML_ERROR_TRY_AGAIN
 * before an element follows the appsrc; ML_ERROR_STREAMS_PIPE after EOS. With
 * ML_PIPELINE_BUF_POLICY_AUTO_FREE, the data stays the program's only after
 * ML_ERROR_INVALID_PARAMETER and ML_ERROR_TRY_AGAIN. */
ML_EXPORT int ml_pipeline_src_input_data(ml_pipeline_src_h src_handle, ml_tensors_data_h data,
                                         ml_pipeline_buf_policy_e policy);
/* Sends EOS from the appsrc. Not in NNStreamer: ML_PIPELINE_BUF_SRC_EVENT_EOS does the same. */
ML_EXPORT int ml_pipeline_src_input_data_eos(ml_pipeline_src_h src_handle);
/* A new info of the tensors that the appsrc takes; without tensors for media, flexible tensors and
 * caps that leave a choice. */
ML_EXPORT int ml_pipeline_src_get_tensors_info(ml_pipeline_src_h src_handle,
                                               ml_tensors_info_h* info);
/* Signals of the appsrc; each function may be NULL. `enough_data` is called within a push: one that
 * it makes itself has the same tensors, or caps fix them. */
typedef struct {
  void (*need_data)(ml_pipeline_src_h src_handle, unsigned int length, void* user_data);
  void (*enough_data)(ml_pipeline_src_h src_handle, void* user_data);
  void (*seek_data)(ml_pipeline_src_h src_handle, uint64_t offset, void* user_data);
} ml_pipeline_src_callbacks_s;
/* Copies *cb, which replaces the functions before, until the handle is released or the pipeline
 * destroyed. */
ML_EXPORT int ml_pipeline_src_set_event_cb(ml_pipeline_src_h src_handle,
                                           ml_pipeline_src_callbacks_s* cb, void* user_data);

typedef enum ML_ANY_INT {
  ML_PIPELINE_SWITCH_OUTPUT_SELECTOR = 0,
  ML_PIPELINE_SWITCH_INPUT_SELECTOR = 1
} ml_pipeline_switch_e;

/* Finds the input-selector or output-selector `switch_name`. `type` may be NULL. */
ML_EXPORT int ml_pipeline_switch_get_handle(ml_pipeline_h pipe, const char* switch_name,
                                            ml_pipeline_switch_e* type,
                                            ml_pipeline_switch_h* switch_handle);
ML_EXPORT int ml_pipeline_switch_release_handle(ml_pipeline_switch_h switch_handle);
/* Activates the pad `pad_name`, such as "sink_1". */
ML_EXPORT int ml_pipeline_switch_select(ml_pipeline_switch_h switch_handle, const char* pad_name);
/* The pads that can be selected, as a NULL-terminated list; free() each name and the list. */
ML_EXPORT int ml_pipeline_switch_get_pad_list(ml_pipeline_switch_h switch_handle, char*** list);

/* Finds the valve `valve_name`. An open valve lets frames pass. */
ML_EXPORT int ml_pipeline_valve_get_handle(ml_pipeline_h pipe, const char* valve_name,
                                           ml_pipeline_valve_h* valve_handle);
ML_EXPORT int ml_pipeline_valve_release_handle(ml_pipeline_valve_h valve_handle);
ML_EXPORT int ml_pipeline_valve_set_open(ml_pipeline_valve_h valve_handle, bool open);

/* Finds any element, to set and get its properties. ML_ERROR_INVALID_PARAMETER if a property has
 * another type than the function: bool for boolean (0 or 1), int64 also for long, uint64 for ulong,
 * double for float, int32 and uint32 for enum. Free returned strings with free(). */
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

/* Computes the outputs of `tensor_filter framework=custom-easy model=NAME` and of ml_single_open:
 * fills `out`. Returns 0; above 0 to drop the frame; below 0 to end the stream with an error. */
typedef int (*ml_custom_easy_invoke_cb)(const ml_tensors_data_h in, ml_tensors_data_h out,
                                        void* user_data);
/* Registers `cb`, called by one thread at a time. The infos are copied; `user_data` must stay valid
 * until unregister has returned. */
ML_EXPORT int ml_pipeline_custom_easy_filter_register(const char* name, const ml_tensors_info_h in,
                                                      const ml_tensors_info_h out,
                                                      ml_custom_easy_invoke_cb cb, void* user_data,
                                                      ml_custom_easy_filter_h* custom);
/* ML_ERROR_INVALID_PARAMETER while a pipeline that uses the filter exists. Waits for a callback of
 * ml_single_invoke running on another thread. */
ML_EXPORT int ml_pipeline_custom_easy_filter_unregister(ml_custom_easy_filter_h custom);

/* The condition of `tensor_if compared-value=CUSTOM compared-value-option=NAME`: sets *result to 0
 * for the ELSE branch, to anything else for THEN. Returns 0; another number is an error of the
 * stream. */
typedef int (*ml_pipeline_if_custom_cb)(const ml_tensors_data_h data, const ml_tensors_info_h info,
                                        int* result, void* user_data);
/* Registers `cb`; `user_data` must stay valid until unregister has returned. */
ML_EXPORT int ml_pipeline_tensor_if_custom_register(const char* name, ml_pipeline_if_custom_cb cb,
                                                    void* user_data, ml_pipeline_if_h* if_custom);
/* ML_ERROR_INVALID_PARAMETER while a pipeline that uses the condition exists. */
ML_EXPORT int ml_pipeline_tensor_if_custom_unregister(ml_pipeline_if_h if_custom);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_H */
