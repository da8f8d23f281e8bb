/* Pipelines for programs: parse the text of gst-launch-1.0, push and pull frames, control elements
 * by their name=. The API exposes no GStreamer types, except that weir_pipeline_adopt takes a
 * GstPipeline. In C++: pipeline.hpp. Link with libweir-pipeline (pkg-config weir-pipeline).
 *
 * Functions that return int return 0 on success and -code (codes.h) on failure, with *error set to
 * an object for weir_error_free unless `error` is NULL; a value above 0 where documented. After an
 * element has posted an error on the bus, every call fails with it until weir_pipeline_stop, except
 * weir_pipeline_read_message; the first error with a code of Weir takes the place of one that
 * GStreamer's elements posted before. Pointers must not be NULL unless documented; for a NULL
 * pointer functions return -WEIR_OPTION_VALUE, a count of 0, a time of -1, or "". Times are in ns,
 * -1 = none.
 *
 * Any thread may call. A callback must not wait for itself: weir_pipeline_stop fails with CANCELLED
 * on every streaming thread of the pipeline (frame and state functions, custom filters, conditions,
 * converters, decoders); weir_pipeline_start, _pause and _wait without a limit fail with CANCELLED
 * in frame and state functions. weir_pipeline_free works everywhere.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_PIPELINE_H
#define WEIR_PIPELINE_H
#include "weir/abi.h"
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct weir_pipeline weir_pipeline;
typedef struct weir_pulled weir_pulled; /* a frame pulled from a pipeline */

enum weir_pipeline_state { WEIR_PIPELINE_STOPPED = 0, WEIR_PIPELINE_PAUSED, WEIR_PIPELINE_PLAYING };
/* Return values of weir_pipeline_wait and _pull on success. */
enum weir_pipeline_result {
  WEIR_PIPELINE_DONE = 0,
  WEIR_PIPELINE_TIME_PASSED,
  WEIR_PIPELINE_ENDED
};

/* Parses a pipeline; initialises GStreamer if necessary. OPTION_SYNTAX for text that does not
 * parse, OPTION_VALUE for an element that does not exist. */
WEIR_EXPORT int weir_pipeline_parse(const char* text, weir_pipeline** pipeline, weir_error** error);
/* Does the same as weir_pipeline_parse, restricted to elements of the `n_allowed` factories in
 * `allowed`. Bins and capsfilters created by parentheses and caps in the text are always allowed.
 * Returns 1, with *error naming the first other factory and *pipeline NULL, if the text names one:
 * as an element, a URI, or in a property that takes elements. No element is created then. Elements
 * that bins such as decodebin add are checked too: one that is not allowed passes no data, and
 * every later call fails with its error. */
WEIR_EXPORT int weir_pipeline_parse_allowed(const char* text, const char* const* allowed,
                                            uint32_t n_allowed, weir_pipeline** pipeline,
                                            weir_error** error);
/* Makes a weir_pipeline of a GstPipeline in the state NULL, which the program has built with
 * GStreamer; a floating reference is taken, otherwise one is added. OPTION_VALUE for another object
 * or state, and for a pipeline that a weir_pipeline has adopted and that is not freed; no reference
 * is taken then.
 * Messages no longer come to the bus, and a sync handler of the program is replaced: warnings and
 * errors come to weir_pipeline_read_message, and all messages to weir_pipeline_on_message. Weir
 * itself handles those that change latency, clock and state. Each appsrc gets format=time.
 * Weir pulls the frames of each appsink, with emit-signals=true, and of each tensor_sink: when 64
 * frames wait for weir_pipeline_pull, a tensor_sink blocks, unless weir_pipeline_discard drops
 * them. An appsrc whose caps were not set starts again, after weir_pipeline_stop, with the caps of
 * its last frame until the next one. */
struct _GstElement;
WEIR_EXPORT int weir_pipeline_adopt(struct _GstElement* element, weir_pipeline** pipeline,
                                    weir_error** error);
/* Stops and frees the pipeline; NULL: no effect. No frame or state function runs after it returns.
 * In a callback it returns immediately, and the stream stops when that callback has returned. */
WEIR_EXPORT void weir_pipeline_free(weir_pipeline* pipeline);

/* The functions below find an element by its name. If bins have elements of this name too, they
 * take the one at the top level of the pipeline. Without one there, a source or sink whose name is
 * not unique is OPTION_VALUE. */

/* Starts the pipeline or resumes it from a pause. Returns before the first frame is through. */
WEIR_EXPORT int weir_pipeline_start(weir_pipeline* pipeline, weir_error** error);
/* Returns immediately even when a sink's queue is full; that sink reaches the paused state with the
 * next weir_pipeline_pull. */
WEIR_EXPORT int weir_pipeline_pause(weir_pipeline* pipeline, weir_error** error);
/* Discards frames in the pipeline, frames not pulled, and the error with which calls fail. Messages
 * stay for weir_pipeline_read_message. */
WEIR_EXPORT int weir_pipeline_stop(weir_pipeline* pipeline, weir_error** error);
/* Returns the weir_pipeline_state: the current state, or the target of a state change. */
WEIR_EXPORT int weir_pipeline_get_state(weir_pipeline* pipeline);
/* Waits until every stream has ended. Returns WEIR_PIPELINE_DONE or WEIR_PIPELINE_TIME_PASSED.
 * timeout_ns -1: no limit. CANCELLED when another thread stops the pipeline. Frames that are not
 * pulled block their stream: see weir_pipeline_pull. */
WEIR_EXPORT int weir_pipeline_wait(weir_pipeline* pipeline, int64_t timeout_ns, weir_error** error);

enum weir_pipeline_message {
  WEIR_PIPELINE_NO_MESSAGE = 0,
  WEIR_PIPELINE_WARNING,
  WEIR_PIPELINE_ERROR
};
/* Removes the oldest warning or error that an element posted and returns its kind, with *message
 * for weir_error_free; WEIR_PIPELINE_NO_MESSAGE and NULL if none is left. Warnings say for example
 * that a new value of a property is not used. The errors are all that were posted, also those after
 * the one with which calls fail. The newest 64 messages are kept until they are read, also over
 * weir_pipeline_stop. Never fails with the error of the stream. */
WEIR_EXPORT int weir_pipeline_read_message(weir_pipeline* pipeline, weir_error** message,
                                           weir_error** error);

/* Pushes a frame into the appsrc `name`; the bytes are copied. If the text sets the appsrc's caps,
 * or the element after it accepts only one (a capsfilter), the tensors must match them
 * (SPEC_MISMATCH, FRAME_SIZE); media take tensors of any type with the bytes of a frame, pictures
 * with or without GStreamer's padding of rows. Otherwise the caps are static tensors derived from
 * the types and shapes, which every tensor must have, and change with them. A tensor without
 * elements, which has a dimension of 0, makes them flexible; where the caps are others, a GAP event
 * with the time of the frame takes its place, and without a time it is dropped. CANCELLED when the
 * pipeline is stopped or after weir_pipeline_end, and for other tensors in a callback of a push
 * that has not returned. Does not block unless the text sets block=true. */
WEIR_EXPORT int weir_pipeline_push(weir_pipeline* pipeline, const char* name,
                                   const weir_tensor* tensors, uint32_t n_tensors, int64_t pts,
                                   int64_t duration, weir_error** error);
/* Describes the tensors that a frame of the appsrc `name` must have: those of its caps, or of the
 * only caps that the element after it accepts. Returns their number and writes the first `n_infos`
 * of them, without names; 0 for media, flexible tensors and caps that leave a choice. `infos` may
 * be NULL if `n_infos` is 0. */
WEIR_EXPORT int weir_pipeline_source_tensors(weir_pipeline* pipeline, const char* name,
                                             weir_tensor_info* infos, uint32_t n_infos,
                                             weir_error** error);
/* Sends EOS from the appsrc `name`. */
WEIR_EXPORT int weir_pipeline_end(weir_pipeline* pipeline, const char* name, weir_error** error);

/* Pulls the next frame of the appsink or tensor_sink `name`: WEIR_PIPELINE_DONE with *frame for
 * weir_pulled_free, or WEIR_PIPELINE_TIME_PASSED or WEIR_PIPELINE_ENDED with NULL in *frame.
 * timeout_ns -1: no limit. Frames are queued from start on: 64 for a tensor_sink, max-buffers for
 * an appsink. A full queue blocks the stream, or drops its oldest frame with appsink drop=true. */
WEIR_EXPORT int weir_pipeline_pull(weir_pipeline* pipeline, const char* name, int64_t timeout_ns,
                                   weir_pulled** frame, weir_error** error);
/* Returns 1 when the sink's stream has ended and every frame has been pulled, otherwise 0. */
WEIR_EXPORT int weir_pipeline_ended(weir_pipeline* pipeline, const char* name, weir_error** error);
/* Called on a streaming thread for each frame, which is valid for the call; weir_pulled_keep
 * extends that. Returns 0, or a code below 0 with *error = weir_error_new(...), which ends the
 * stream with CALLBACK_FAILED. */
typedef int (*weir_frame_function)(const weir_pulled* frame, void* data, weir_error** error);
/* Calls `function` for each frame instead of queueing it; NULL returns to pulling. Only while
 * stopped. `data` must stay valid until it is replaced or the pipeline is freed. */
WEIR_EXPORT int weir_pipeline_on_frame(weir_pipeline* pipeline, const char* name,
                                       weir_frame_function function, void* data,
                                       weir_error** error);

/* Drops the frames of the appsink or tensor_sink `name` without reading them, instead of queueing
 * them, until the next weir_pipeline_on_frame. Only while stopped. */
WEIR_EXPORT int weir_pipeline_discard(weir_pipeline* pipeline, const char* name,
                                      weir_error** error);

/* Called after each state change of the whole pipeline (weir_pipeline_state), on the thread that
 * changed it. It cannot change the state itself (CANCELLED). Only while stopped; NULL: no calls. */
typedef void (*weir_state_function)(int state, void* data);
WEIR_EXPORT int weir_pipeline_on_state(weir_pipeline* pipeline, weir_state_function function,
                                       void* data, weir_error** error);

/* Called for each message of GStreamer that an element or the pipeline posts, after Weir has
 * handled it, on the thread that posts it, which may hold locks: return soon, and change no state
 * (CANCELLED). A program with a main loop passes messages on to a bus of its own: gst_bus_post(bus,
 * gst_message_ref(message)). The message is valid for the call. Only while stopped; NULL: no calls.
 * `data` must stay valid until it is replaced or the pipeline is freed. */
struct _GstMessage;
typedef void (*weir_message_function)(struct _GstMessage* message, void* data);
WEIR_EXPORT int weir_pipeline_on_message(weir_pipeline* pipeline, weir_message_function function,
                                         void* data, weir_error** error);

/* Returns the number of tensors of a frame. */
WEIR_EXPORT uint32_t weir_pulled_count(const weir_pulled* frame);
/* Describes tensor `index`; -WEIR_OPTION_VALUE for an invalid one. The memory is read-only and
 * lives as long as the frame. A frame of media is one uint8 tensor. */
WEIR_EXPORT int weir_pulled_tensor(const weir_pulled* frame, uint32_t index, weir_tensor* tensor);
/* Returns the text of a field of the caps, "" if they have no such field with a text: weir-columns
 * and weir-source of results (results.h). Valid as long as the frame, or a copy of it. */
WEIR_EXPORT const char* weir_pulled_caps_field(const weir_pulled* frame, const char* field);
/* Returns the label of a class in tensor `index` of results, from the stream's event weir-labels;
 * "" if the stream has none for it. Valid as long as the frame, or a copy of it. */
WEIR_EXPORT const char* weir_pulled_label(const weir_pulled* frame, uint32_t index,
                                          int32_t class_index);
/* Returns the number of source maps: 0 for a frame that does not come from a picture, 1 for all of
 * its tensors, or one for each; of a batch of regions one for each region. */
WEIR_EXPORT uint32_t weir_pulled_map_count(const weir_pulled* frame);
/* Copies source map `index`; -WEIR_OPTION_VALUE for an invalid one. */
WEIR_EXPORT int weir_pulled_map(const weir_pulled* frame, uint32_t index, weir_source_map* map);
/* Return the PTS of the buffer and its duration in ns; -1 = none. */
WEIR_EXPORT int64_t weir_pulled_pts(const weir_pulled* frame);
WEIR_EXPORT int64_t weir_pulled_duration(const weir_pulled* frame);
WEIR_EXPORT const char* weir_pulled_caps(const weir_pulled* frame);  /* GStreamer caps text */
WEIR_EXPORT weir_pulled* weir_pulled_keep(const weir_pulled* frame); /* NULL: out of memory */
WEIR_EXPORT void weir_pulled_free(weir_pulled* frame);               /* NULL: no effect */

/* Opens or closes the valve `name`. */
WEIR_EXPORT int weir_pipeline_set_valve(weir_pipeline* pipeline, const char* name, int open,
                                        weir_error** error);
/* Activates a pad, such as "sink_1", of the input-selector or output-selector `name`. A frame
 * already inside an output-selector still goes to the previous pad. */
WEIR_EXPORT int weir_pipeline_select(weir_pipeline* pipeline, const char* name, const char* pad,
                                     weir_error** error);
/* Set and get properties as text, as in gst-launch-1.0. OPTION_VALUE for a property that does not
 * exist, cannot be set in this state, or does not accept the value. While the element runs, the
 * error with which it rejects the value, such as a model that cannot replace the current one. */
WEIR_EXPORT int weir_pipeline_set(weir_pipeline* pipeline, const char* name, const char* property,
                                  const char* value, weir_error** error);
WEIR_EXPORT int weir_pipeline_get(weir_pipeline* pipeline, const char* name, const char* property,
                                  char** value, weir_error** error);
/* Gets a property as JSON, with structures such as the property "stats" as objects. */
WEIR_EXPORT int weir_pipeline_get_json(weir_pipeline* pipeline, const char* name,
                                       const char* property, char** json, weir_error** error);
/* Frees a text of weir_pipeline_get or _get_json; NULL: no effect. */
WEIR_EXPORT void weir_pipeline_text_free(char* text);
/* The type of a property: one of these, above 0, or -code. */
enum weir_property_type {
  WEIR_PROPERTY_OTHER = 1,
  WEIR_PROPERTY_BOOL,
  WEIR_PROPERTY_INT32,
  WEIR_PROPERTY_UINT32,
  WEIR_PROPERTY_INT64,
  WEIR_PROPERTY_UINT64,
  WEIR_PROPERTY_DOUBLE, /* float too */
  WEIR_PROPERTY_STRING,
  WEIR_PROPERTY_ENUM
};
WEIR_EXPORT int weir_pipeline_property_type(weir_pipeline* pipeline, const char* name,
                                            const char* property, weir_error** error);
/* Gets the number of an enum property's value; weir_pipeline_get returns it as text. */
WEIR_EXPORT int weir_pipeline_get_enum(weir_pipeline* pipeline, const char* name,
                                       const char* property, int32_t* value, weir_error** error);

/* Returns the element `name` (NULL: the GstPipeline) with a reference for gst_object_unref; NULL if
 * there is none. weir_pipeline_stop may replace an appsrc. */
WEIR_EXPORT struct _GstElement* weir_pipeline_get_element(weir_pipeline* pipeline,
                                                          const char* name);
/* Calls `function` for each element in the order of the text. `kind` is the factory name ("valve");
 * `depth` is 0 for elements of the text and greater for those inside bins such as decodebin. The
 * texts are valid for the call. */
typedef void (*weir_element_function)(const char* name, const char* kind, int depth, void* data);
WEIR_EXPORT int weir_pipeline_elements(weir_pipeline* pipeline, weir_element_function function,
                                       void* data, weir_error** error);
/* Does the same for the current pads of the element `name`; `source`: 1 or 0. */
typedef void (*weir_pad_function)(const char* name, int source, void* data);
WEIR_EXPORT int weir_pipeline_pads(weir_pipeline* pipeline, const char* name,
                                   weir_pad_function function, void* data, weir_error** error);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_PIPELINE_H */
