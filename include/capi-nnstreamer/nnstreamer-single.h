/* Opens and invokes one model without a pipeline: ml_single_*. C99; pkg-config
 * capi-ml-inference-single.
 * Implemented with weir/model.h; docs/guide/from-nnstreamer.md lists the coverage.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_SINGLE_H
#define NNSTREAMER_SINGLE_H
#include "ml-api-common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef void* ml_single_h;

/* Opens `model`, the path of a file or several separated by commas. The infos describe tensors that
 * the model does not describe; otherwise pass NULL. An input_info that differs from the model
 * resizes its inputs. ML_ERROR_INVALID_PARAMETER for a file that does not exist or is not one of
 * the framework's, and for infos that the model cannot have; ML_ERROR_NOT_SUPPORTED for an engine
 * or hardware that is not available; ML_ERROR_STREAMS_PIPE for a model that the engine refuses. */
ML_EXPORT int ml_single_open(ml_single_h* single, const char* model,
                             const ml_tensors_info_h input_info,
                             const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                             ml_nnfw_hw_e hw);
/* `custom_option` is custom= of tensor_filter: key:value,key:value; NULL: none. */
ML_EXPORT int ml_single_open_full(ml_single_h* single, const char* model,
                                  const ml_tensors_info_h input_info,
                                  const ml_tensors_info_h output_info, ml_nnfw_type_e nnfw,
                                  ml_nnfw_hw_e hw, const char* custom_option);
/* Opens a model as options say. Values are pointers, and unknown keys are ignored: models (char*,
 * the path), input_info and output_info (handles), nnfw (ml_nnfw_type_e*), hw (ml_nnfw_hw_e*),
 * custom (char*), framework_name or framework (char*, wins over nnfw), invoke_async ("true"; needs
 * async_callback, an int (*)(const ml_tensors_data_h data, void* user_data) that gets the outputs
 * of each invoke, valid for the call, and async_data, its user_data). */
ML_EXPORT int ml_single_open_with_option(ml_single_h* single, const ml_option_h option);
/* Waits for an invoke on another thread, but not for one that has run out of time. */
ML_EXPORT int ml_single_close(ml_single_h single);

/* Free *output with ml_tensors_data_destroy. ML_ERROR_TIMED_OUT: see ml_single_set_timeout. */
ML_EXPORT int ml_single_invoke(ml_single_h single, const ml_tensors_data_h input,
                               ml_tensors_data_h* output);
/* Invokes into existing memory: create `output` with the info of the outputs. */
ML_EXPORT int ml_single_invoke_fast(ml_single_h single, const ml_tensors_data_h input,
                                    ml_tensors_data_h output);
/* Sets the inputs as in_info describes them and invokes. They stay set unless this fails. Destroy
 * *output and *out_info. */
ML_EXPORT int ml_single_invoke_dynamic(ml_single_h single, const ml_tensors_data_h input,
                                       const ml_tensors_info_h in_info, ml_tensors_data_h* output,
                                       ml_tensors_info_h* out_info);

/* The current tensors. Open dimensions are 1; a tensor without type or rank makes
 * ml_tensors_info_validate return false. Free *info with ml_tensors_info_destroy. */
ML_EXPORT int ml_single_get_input_info(ml_single_h single, ml_tensors_info_h* info);
ML_EXPORT int ml_single_get_output_info(ml_single_h single, ml_tensors_info_h* info);
/* Sets the dimensions that the model leaves open, and those of models that can be resized
 * (TensorFlow Lite). On failure nothing changes. ML_ERROR_NOT_SUPPORTED: the engine cannot resize.
 */
ML_EXPORT int ml_single_set_input_info(ml_single_h single, const ml_tensors_info_h info);

/* Limits the duration of later invokes, in ms; 0: no limit. After ML_ERROR_TIMED_OUT the engine
 * continues, and until it ends every invoke returns ML_ERROR_TRY_AGAIN. */
ML_EXPORT int ml_single_set_timeout(ml_single_h single, unsigned int timeout);

/* Properties of tensor_filter: input, inputtype, inputname, inputlayout, the same of output,
 * accelerator, custom, is-updatable, framework and model. Setting input (as "4:2,4:2"), inputtype
 * or inputname does what ml_single_set_input_info does; others cannot change, and setting them has
 * no effect. ML_ERROR_NOT_SUPPORTED for another name. */
ML_EXPORT int ml_single_set_property(ml_single_h single, const char* name, const char* value);
/* Free *value with free(); NULL for a property that does not exist. */
ML_EXPORT int ml_single_get_property(ml_single_h single, const char* name, char** value);

#ifdef __cplusplus
}
#endif
#endif /* NNSTREAMER_SINGLE_H */
