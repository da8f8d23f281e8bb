/* Pipelines of a program: made from the text that gst-launch-1.0 takes, frames pushed and pulled,
 * elements found by their name= and switched. No type of GStreamer shows. In C++: pipeline.hpp.
 * Link with libweir-pipeline (pkg-config weir-pipeline).
 *
 * Functions that return int: 0 = success; -code (codes.h) = failure, with *error set to an object
 * for weir_error_free unless `error` is NULL; above 0 where it is said. What an element reports on
 * its bus is an error of every later call, until weir_pipeline_stop. No pointer may be NULL unless
 * said; one that is gives -WEIR_OPTION_VALUE, a count of 0, a time of -1, or "". Times are in ns,
 * -1 = none.
 *
 * Any thread may call. A callback must not wait for itself: weir_pipeline_stop fails with CANCELLED
 * on every thread of the pipeline's own stream (frame and state functions, custom filters,
 * conditions, converters, decoders); weir_pipeline_start, _pause and _wait without a limit fail
 * with CANCELLED in frame and state functions. weir_pipeline_free works everywhere. */
#ifndef WEIR_PIPELINE_H
#define WEIR_PIPELINE_H
#include "weir/abi.h"
#include "weir/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct weir_pipeline weir_pipeline;
typedef struct weir_pulled weir_pulled; /* a frame that came out of a pipeline */

enum weir_pipeline_state { WEIR_PIPELINE_STOPPED = 0, WEIR_PIPELINE_PAUSED, WEIR_PIPELINE_PLAYING };
/* What weir_pipeline_wait and _pull return where they end without an error. */
enum weir_pipeline_answer {
  WEIR_PIPELINE_DONE = 0,
  WEIR_PIPELINE_TIME_PASSED,
  WEIR_PIPELINE_ENDED
};

/* Starts GStreamer where the program has not. OPTION_SYNTAX for a text that cannot be read,
 * OPTION_VALUE for an element that is not there. */
WEIR_EXPORT int weir_pipeline_parse(const char* text, weir_pipeline** pipeline, weir_error** error);
/* The same, with elements of the `n_allowed` factories in `allowed` only; the bins and capsfilters
 * that a text makes of parentheses and caps are always allowed. 1, with *error naming the first
 * other factory and *pipeline NULL, where the text names one: as an element, a URI, or in a
 * property that takes elements. No element is made then. What bins such as decodebin add counts
 * too: an element that is added later passes no data and is the error of every later call. */
WEIR_EXPORT int weir_pipeline_parse_allowed(const char* text, const char* const* allowed,
                                            uint32_t n_allowed, weir_pipeline** pipeline,
                                            weir_error** error);
/* Stops and frees the pipeline; NULL: no effect. No frame or state function runs after it returns.
 * Called in a callback, it returns at once and the stream stops when that callback has returned. */
WEIR_EXPORT void weir_pipeline_free(weir_pipeline* pipeline);

/* Start also goes on from a pause. It returns before the first frame has come through. */
WEIR_EXPORT int weir_pipeline_start(weir_pipeline* pipeline, weir_error** error);
/* Returns at once even when a sink's queue is full; that sink reaches the paused state with the
 * next weir_pipeline_pull. */
WEIR_EXPORT int weir_pipeline_pause(weir_pipeline* pipeline, weir_error** error);
/* Frames inside and frames not pulled are gone, errors too. */
WEIR_EXPORT int weir_pipeline_stop(weir_pipeline* pipeline, weir_error** error);
/* One of weir_pipeline_state: where it is, or where it is on its way to. */
WEIR_EXPORT int weir_pipeline_get_state(weir_pipeline* pipeline);
/* Until every stream has ended: WEIR_PIPELINE_DONE, or WEIR_PIPELINE_TIME_PASSED. timeout_ns -1: no
 * limit. CANCELLED when another thread stops the pipeline meanwhile. Frames that nobody pulls stop
 * their stream: see weir_pipeline_pull. */
WEIR_EXPORT int weir_pipeline_wait(weir_pipeline* pipeline, int64_t timeout_ns, weir_error** error);

/* Hands a frame to the appsrc `name`; bytes are copied. Where the text gives the appsrc caps, the
 * tensors are held against them (SPEC_MISMATCH, FRAME_SIZE); media take one uint8 tensor with the
 * bytes of a frame. Where it does not, the caps are static tensors, written from types and shapes,
 * which each tensor must have then, and change with them. CANCELLED when the pipeline is stopped or
 * weir_pipeline_end came before. Does not wait, unless the text says block=true. */
WEIR_EXPORT int weir_pipeline_push(weir_pipeline* pipeline, const char* name,
                                   const weir_tensor* tensors, uint32_t n_tensors, int64_t pts,
                                   int64_t duration, weir_error** error);
WEIR_EXPORT int weir_pipeline_end(weir_pipeline* pipeline, const char* name, weir_error** error);

/* The next frame of the appsink or tensor_sink `name`: WEIR_PIPELINE_DONE with *frame for
 * weir_pulled_free, WEIR_PIPELINE_TIME_PASSED, or WEIR_PIPELINE_ENDED; *frame is NULL then.
 * timeout_ns -1: no limit. Frames are kept from start on, 64 of a tensor_sink, of an appsink as its
 * max-buffers says; then the stream waits, or with appsink drop=true the oldest goes. */
WEIR_EXPORT int weir_pipeline_pull(weir_pipeline* pipeline, const char* name, int64_t timeout_ns,
                                   weir_pulled** frame, weir_error** error);
/* 1: the stream of this sink has ended and every frame has been pulled; 0: not so. */
WEIR_EXPORT int weir_pipeline_ended(weir_pipeline* pipeline, const char* name, weir_error** error);
/* Called on a thread of the stream for each frame, which lives for the call; weir_pulled_keep keeps
 * it. Returns 0, or a code below 0 with *error = weir_error_new(...): it ends the stream with
 * CALLBACK_FAILED. */
typedef int (*weir_frame_function)(const weir_pulled* frame, void* data, weir_error** error);
/* Instead of pulling. Only while stopped; `function` NULL: pulled again. `data` must live until it
 * is replaced or the pipeline is freed. */
WEIR_EXPORT int weir_pipeline_on_frame(weir_pipeline* pipeline, const char* name,
                                       weir_frame_function function, void* data,
                                       weir_error** error);

/* Called each time the whole pipeline has another state (weir_pipeline_state), on the thread that
 * changed it. It cannot change the state itself (CANCELLED). Only while stopped; NULL: no calls. */
typedef void (*weir_state_function)(int state, void* data);
WEIR_EXPORT int weir_pipeline_on_state(weir_pipeline* pipeline, weir_state_function function,
                                       void* data, weir_error** error);

WEIR_EXPORT uint32_t weir_pulled_count(const weir_pulled* frame);
/* -WEIR_OPTION_VALUE for an index beyond. The memory lives as long as the frame; it is not to be
 * written. Frames of media are one uint8 tensor. */
WEIR_EXPORT int weir_pulled_tensor(const weir_pulled* frame, uint32_t index, weir_tensor* tensor);
WEIR_EXPORT int64_t weir_pulled_pts(const weir_pulled* frame);
WEIR_EXPORT int64_t weir_pulled_duration(const weir_pulled* frame);
WEIR_EXPORT const char* weir_pulled_caps(const weir_pulled* frame);  /* GStreamer's text */
WEIR_EXPORT weir_pulled* weir_pulled_keep(const weir_pulled* frame); /* NULL: no memory */
WEIR_EXPORT void weir_pulled_free(weir_pulled* frame);               /* NULL: nothing */

/* The element valve `name`. */
WEIR_EXPORT int weir_pipeline_set_valve(weir_pipeline* pipeline, const char* name, int open,
                                        weir_error** error);
/* The element input-selector or output-selector `name`: its pad, such as "sink_1". A frame that is
 * on its way through an output-selector still goes to the pad before; then it changes. */
WEIR_EXPORT int weir_pipeline_select(weir_pipeline* pipeline, const char* name, const char* pad,
                                     weir_error** error);
/* Properties as text, as gst-launch-1.0 writes them. OPTION_VALUE for a property that is not there,
 * cannot be set now, or does not take the value. */
WEIR_EXPORT int weir_pipeline_set(weir_pipeline* pipeline, const char* name, const char* property,
                                  const char* value, weir_error** error);
WEIR_EXPORT int weir_pipeline_get(weir_pipeline* pipeline, const char* name, const char* property,
                                  char** value, weir_error** error);
WEIR_EXPORT void weir_pipeline_text_free(char* text); /* of weir_pipeline_get; NULL: nothing */
/* What a value of the property is: one of these, above 0, or -code. */
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
/* The number of an enum, of which weir_pipeline_get gives the word. */
WEIR_EXPORT int weir_pipeline_get_enum(weir_pipeline* pipeline, const char* name,
                                       const char* property, int32_t* value, weir_error** error);

/* Calls `function` for each element, in the text's order. `kind` is its factory ("valve"); `depth`
 * is 0 for what the text names, above for what is inside an element that is a bin of its own
 * (decodebin). The texts live for the call. */
typedef void (*weir_element_function)(const char* name, const char* kind, int depth, void* data);
WEIR_EXPORT int weir_pipeline_elements(weir_pipeline* pipeline, weir_element_function function,
                                       void* data, weir_error** error);
/* The same for the pads that the element `name` has now; `source`: 1 or 0. */
typedef void (*weir_pad_function)(const char* name, int source, void* data);
WEIR_EXPORT int weir_pipeline_pads(weir_pipeline* pipeline, const char* name,
                                   weir_pad_function function, void* data, weir_error** error);

#ifdef __cplusplus
}
#endif
#endif /* WEIR_PIPELINE_H */
