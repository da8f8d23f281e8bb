/* Tests of ml_pipeline_construct to _destroy, and of sinks. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include "check_test_support.h"
#include "nnstreamer.h"
#include "seen_test_support.h"

static void frames_go_in_and_come_out(const char* text) {
  Seen seen = SEEN, again = SEEN;
  ml_pipeline_h pipe = construct(text);
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL, second = NULL;
  ml_tensors_data_h data = two_floats(3);
  void* memory;
  size_t size;
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink));
  OK(ml_pipeline_sink_register(pipe, "out", see, &again, &second));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE));
  wait_for(&seen.frames, 1);
  wait_for(&again.frames, 1);
  CHECK(seen.last == 3 && seen.width == 2 && again.last == 3);
  OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 2);
  wait_for(&again.frames, 2);
  CHECK_REFUSED(ml_tensors_data_get_tensor_data(data, 0, &memory, &size),
                ML_ERROR_INVALID_PARAMETER, "data is a handle that was destroyed or released");
  OK(ml_pipeline_sink_unregister(second));
  OK(ml_pipeline_src_input_data(src, two_floats(4), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 3);
  CHECK(seen.last == 4 && get_count(&again.frames) == 2);
  OK(ml_pipeline_src_input_data(src, NULL, ML_PIPELINE_BUF_SRC_EVENT_EOS));
  data = two_floats(5);
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_STREAMS_PIPE, "the stream has ended and accepts no more frames");
  CHECK_REFUSED(ml_tensors_data_destroy(data), ML_ERROR_INVALID_PARAMETER, "was destroyed");
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_tensors_data_get_tensor_data(seen.data, 0, &memory, &size),
                ML_ERROR_INVALID_PARAMETER, "was destroyed");
  CHECK_REFUSED(ml_pipeline_sink_unregister(sink), ML_ERROR_INVALID_PARAMETER, "was destroyed");
}

typedef struct {
  Counter count;
  ml_pipeline_state_e states[16];
} States;

static void record_state(ml_pipeline_state_e state, void* user_data) {
  States* states = user_data;
  const int at = get_count(&states->count); /* one thread at a time changes the state */
  CHECK(at < 16);
  if (at < 16) states->states[at] = state;
  raise_count(&states->count);
}

/* Waits for the next state that is reported, and expects that it is that of the pipeline. */
static void expect_state(States* states, int at, ml_pipeline_h pipe, ml_pipeline_state_e wanted) {
  ml_pipeline_state_e state = ML_PIPELINE_STATE_UNKNOWN;
  wait_for(&states->count, at);
  CHECK(get_count(&states->count) == at);
  CHECK(states->states[at - 1] == wanted);
  OK(ml_pipeline_get_state(pipe, &state));
  CHECK(state == wanted);
}

static void states_follow_the_calls(void) {
  States states = {COUNTER, {ML_PIPELINE_STATE_UNKNOWN}};
  ml_pipeline_h pipe = NULL;
  ml_pipeline_state_e state;
  OK(ml_pipeline_construct("videotestsrc is-live=true ! fakesink", record_state, &states, &pipe));
  expect_state(&states, 2, pipe, ML_PIPELINE_STATE_PAUSED);
  CHECK(states.states[0] == ML_PIPELINE_STATE_READY);
  OK(ml_pipeline_stop(pipe)); /* changes nothing */
  OK(ml_pipeline_start(pipe));
  expect_state(&states, 3, pipe, ML_PIPELINE_STATE_PLAYING);
  OK(ml_pipeline_stop(pipe));
  expect_state(&states, 4, pipe, ML_PIPELINE_STATE_PAUSED);
  OK(ml_pipeline_flush(pipe, false)); /* changes nothing */
  OK(ml_pipeline_flush(pipe, true));
  expect_state(&states, 5, pipe, ML_PIPELINE_STATE_PLAYING);
  OK(ml_pipeline_flush(pipe, false));
  expect_state(&states, 6, pipe, ML_PIPELINE_STATE_PAUSED);
  OK(ml_pipeline_destroy(pipe));
  /* A pipeline whose sinks wait for their first frame is not paused yet. */
  OK(ml_pipeline_construct("appsrc ! fakesink", NULL, NULL, &pipe));
  OK(ml_pipeline_get_state(pipe, &state));
  CHECK(state == ML_PIPELINE_STATE_READY);
  OK(ml_pipeline_destroy(pipe));
}

/* What a flush has discarded does not arrive; the running time begins again. */
static void a_flush_discards_frames_and_keeps_the_elements(void) {
  Seen seen = SEEN;
  ml_pipeline_h pipe = construct("appsrc name=in ! tensor_sink name=out");
  ml_pipeline_src_h src = NULL;
  int i;
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &seen.sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  for (i = 0; i < 4; ++i)
    OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_flush(pipe, false));
  OK(ml_pipeline_src_input_data(src, two_floats(2), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_start(pipe));
  wait_for(&seen.frames, 1);
  CHECK(seen.last == 2);
  OK(ml_pipeline_flush(pipe, true));
  OK(ml_pipeline_src_input_data(src, two_floats(3), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 2);
  CHECK(seen.last == 3);
  /* After the end of the stream it can begin again. */
  OK(ml_pipeline_src_input_data_eos(src));
  OK(ml_pipeline_flush(pipe, true));
  OK(ml_pipeline_src_input_data(src, two_floats(4), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 3);
  CHECK(seen.last == 4);
  OK(ml_pipeline_destroy(pipe));
}

/* The first of two frames is too long for the caps. */
static void a_frame_that_does_not_fit_its_caps_is_dropped(void) {
  static const char* const sinks[] = {"tensor_sink", "appsink"};
  size_t i;
  for (i = 0; i < sizeof sinks / sizeof *sinks; ++i) {
    Seen seen = SEEN;
    char text[512];
    ml_pipeline_h pipe;
    ml_pipeline_state_e state;
    snprintf(text, sizeof text,
             "concat name=all ! other/tensors,format=static,num_tensors=1,dimensions=(string)2,"
             "types=float32,framerate=0/1 ! %s name=out sync=false async=false "
             "fakesrc num-buffers=1 sizetype=fixed sizemax=12 filltype=zero ! all. "
             "fakesrc num-buffers=1 sizetype=fixed sizemax=8 filltype=zero ! all.",
             sinks[i]);
    pipe = construct(text);
    OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &seen.sink));
    OK(ml_pipeline_start(pipe));
    wait_for(&seen.frames, 1);
    CHECK(seen.width == 2);
    OK(ml_pipeline_get_state(pipe, &state));
    OK(ml_pipeline_destroy(pipe));
    CHECK(get_count(&seen.frames) == 1);
  }
}

static int fail_always(const ml_tensors_data_h in, ml_tensors_data_h out, void* user_data) {
  (void)in, (void)out, (void)user_data;
  return -7;
}

static void a_failed_element_is_the_error_of_the_state(void) {
  ml_pipeline_h pipe = NULL;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_state_e state = ML_PIPELINE_STATE_UNKNOWN;
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 4, 1);
  ml_tensors_data_h data = NULL;
  ml_custom_easy_filter_h filter = NULL;
  int result = ML_ERROR_NONE;
  OK(ml_pipeline_custom_easy_filter_register("fails", info, info, fail_always, NULL, &filter));
  OK(ml_tensors_data_create(info, &data));
  pipe = construct(
      "appsrc name=in ! tensor_filter framework=custom-easy model=fails ! "
      "tensor_sink name=out sync=false");
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  while (result == ML_ERROR_NONE)
    result = ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE);
  CHECK(result == ML_ERROR_STREAMS_PIPE);
  CHECK(strstr(last_error(), "the callback of fails returned -7"));
  CHECK_REFUSED(ml_pipeline_get_state(pipe, &state), ML_ERROR_STREAMS_PIPE,
                "the callback of fails returned -7");
  CHECK(state != ML_PIPELINE_STATE_UNKNOWN);
  CHECK_REFUSED(ml_pipeline_start(pipe), ML_ERROR_STREAMS_PIPE, "fails returned -7");
  OK(ml_pipeline_flush(pipe, false));
  OK(ml_pipeline_get_state(pipe, &state));
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(pipe));
  OK(ml_pipeline_custom_easy_filter_unregister(filter));
  OK(ml_tensors_data_destroy(data));
  OK(ml_tensors_info_destroy(info));
}

/* Reads the state, unregisters itself, and must fail to stop its own pipeline. */
static void meddle(const ml_tensors_data_h data, const ml_tensors_info_h info, void* user_data) {
  Seen* seen = user_data;
  ml_pipeline_state_e state;
  const float one = 1;
  (void)info;
  OK(ml_pipeline_get_state(seen->pipe, &state));
  CHECK_REFUSED(ml_pipeline_stop(seen->pipe), ML_ERROR_TRY_AGAIN,
                "a callback cannot change the state of its own pipeline");
  CHECK_REFUSED(ml_pipeline_start(seen->pipe), ML_ERROR_TRY_AGAIN,
                "a call in a callback, for which the call would wait");
  CHECK_REFUSED(ml_pipeline_flush(seen->pipe, true), ML_ERROR_TRY_AGAIN,
                "needed: a call on another thread");
  CHECK_REFUSED(ml_pipeline_destroy(seen->pipe), ML_ERROR_TRY_AGAIN,
                "make the call on another thread");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 0, &one, sizeof one),
                ML_ERROR_PERMISSION_DENIED, "this data is read-only");
  OK(ml_pipeline_sink_unregister(seen->sink));
  raise_count(&seen->frames);
}

static void callbacks_may_call(void) {
  Seen seen = SEEN, other = SEEN;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_h pipe = seen.pipe = construct("appsrc name=in ! tensor_sink name=out sync=false");
  OK(ml_pipeline_sink_register(pipe, "out", meddle, &seen, &seen.sink));
  OK(ml_pipeline_sink_register(pipe, "out", see, &other, &other.sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_src_input_data(src, two_floats(2), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&other.frames, 2);
  CHECK(get_count(&seen.frames) == 1);
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_pipeline_sink_unregister(seen.sink), ML_ERROR_INVALID_PARAMETER,
                "sink_handle is a handle that was destroyed or released");
  CHECK_REFUSED(ml_pipeline_sink_unregister(other.sink), ML_ERROR_INVALID_PARAMETER,
                "was destroyed");
  CHECK_REFUSED(ml_pipeline_src_release_handle(src), ML_ERROR_INVALID_PARAMETER, "was destroyed");
}

static void texts_and_names_are_refused(void) {
  ml_pipeline_h pipe = &pipe;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_tensors_data_h data = two_floats(1);
  Seen seen = SEEN;
  CHECK_REFUSED(ml_pipeline_construct(NULL, NULL, NULL, &pipe), ML_ERROR_INVALID_PARAMETER,
                "pipeline_description is a null pointer");
  CHECK(pipe == (void*)&pipe);
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! fakesinc", NULL, NULL, &pipe),
                ML_ERROR_STREAMS_PIPE, "did you mean fakesink?");
  CHECK(pipe == NULL);
  CHECK_REFUSED(ml_pipeline_construct("fakesink", NULL, NULL, NULL), ML_ERROR_INVALID_PARAMETER,
                "pipe is a null pointer");
  CHECK_REFUSED(ml_pipeline_start(NULL), ML_ERROR_INVALID_PARAMETER, "pipe is a null pointer");
  CHECK_REFUSED(ml_pipeline_start(data), ML_ERROR_INVALID_PARAMETER,
                "pipe is a handle of a different type");
  pipe = construct("appsrc name=in ! tensor_sink name=out sync=false");
  CHECK_REFUSED(ml_pipeline_sink_register(pipe, "oud", see, &seen, &sink),
                ML_ERROR_INVALID_PARAMETER, "did you mean out?");
  CHECK_REFUSED(ml_pipeline_sink_register(pipe, "in", see, &seen, &sink),
                ML_ERROR_INVALID_PARAMETER,
                "the element in does not support this call\n  offered: appsrc\n"
                "  needed: tensor_sink or appsink");
  CHECK_REFUSED(ml_pipeline_sink_register(pipe, "out", NULL, &seen, &sink),
                ML_ERROR_INVALID_PARAMETER, "null pointer");
  CHECK_REFUSED(ml_pipeline_src_get_handle(pipe, "out", &src), ML_ERROR_INVALID_PARAMETER,
                "needed: appsrc");
  CHECK_REFUSED(ml_pipeline_src_get_handle(pipe, NULL, &src), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, (ml_pipeline_buf_policy_e)9),
                ML_ERROR_INVALID_PARAMETER, "policy is not a value");
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_MAX),
                ML_ERROR_INVALID_PARAMETER, "policy is not a value");
  CHECK_REFUSED(ml_pipeline_src_input_data(data, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_INVALID_PARAMETER, "src_handle is a handle of a different type");
  CHECK_REFUSED(ml_pipeline_src_input_data(src, NULL, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_INVALID_PARAMETER, "data is a null pointer");
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_pipeline_destroy(pipe), ML_ERROR_INVALID_PARAMETER,
                "pipe is a handle that was destroyed or released");
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_INVALID_PARAMETER,
                "src_handle is a handle that was destroyed or released");
  OK(ml_tensors_data_destroy(data));
}

#define BIN                                                                       \
  "bin.( videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=4,height=4 ! " \
  "tensor_converter ! tensor_sink name=out ) "

static void sinks_of_one_name_play_and_are_refused(void) {
  ml_pipeline_h pipe = construct(BIN BIN "appsrc name=in ! tensor_sink");
  Seen seen = SEEN;
  ml_pipeline_sink_h sink = NULL;
  CHECK_REFUSED(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink),
                ML_ERROR_INVALID_PARAMETER,
                "several sinks of the pipeline have this name\n  offered: out in several bins");
  OK(ml_pipeline_start(pipe));
  OK(ml_pipeline_destroy(pipe));
}

/* Nothing is left of a pipeline that cannot be constructed. */
static void a_pipeline_that_cannot_be_paused_is_refused(void) {
  static const char* const texts[] = {
      "",
      "videotestsrc ! ",
      "videotestsrc nosuchproperty=1 ! fakesink",
      "videotestsrc ! audioconvert ! fakesink",
      "filesrc location=/no/such/file ! fakesink",
      "appsrc ! tensor_filter framework=custom-easy model=nosuchfilter ! fakesink",
      "appsrc ! tensor_filter framework=nosuchframework model=x ! fakesink",
      "appsrc ! tensor_filter framework=tensorflow-lite model=/no/such.tflite ! fakesink"};
  size_t i;
  for (i = 0; i < sizeof texts / sizeof *texts; ++i) {
    ml_pipeline_h pipe = &pipe;
    const int result = ml_pipeline_construct(texts[i], NULL, NULL, &pipe);
    if (result != ML_ERROR_STREAMS_PIPE || pipe) {
      REPORT("constructed with %d: %s\n", result, texts[i]);
      ++failed_checks;
    }
  }
}

static void elements_and_frameworks_are_available(void) {
  bool available = false;
  OK(ml_check_element_availability("tensor_filter", &available));
  CHECK(available);
  OK(ml_check_element_availability("videotestsrc", &available));
  CHECK(available);
  OK(ml_check_element_availability("nosuchelement", &available));
  CHECK(!available);
  OK(ml_check_element_availability(ML_TIZEN_CAM_VIDEO_SRC, &available));
  CHECK(!available);
  CHECK_REFUSED(ml_check_element_availability(NULL, &available), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  CHECK_REFUSED(ml_check_element_availability("x", NULL), ML_ERROR_INVALID_PARAMETER,
                "null pointer");
  OK(ml_check_nnfw_availability(ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY, &available));
  CHECK(available);
  OK(ml_check_nnfw_availability(ML_NNFW_TYPE_CUSTOM_FILTER, (ml_nnfw_hw_e)77, &available));
  CHECK(available); /* an unknown number is AUTO */
  OK(ml_check_nnfw_availability_full(ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_NPU, "a:b",
                                     &available));
  CHECK(!available);
  OK(ml_check_nnfw_availability(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_ANY, &available));
  CHECK(!available);
  available = true;
  CHECK_REFUSED(ml_check_nnfw_availability(ML_NNFW_TYPE_ANY, ML_NNFW_HW_ANY, &available),
                ML_ERROR_INVALID_PARAMETER, "nnfw names no framework");
  CHECK(!available);
  CHECK_REFUSED(ml_check_nnfw_availability((ml_nnfw_type_e)4711, ML_NNFW_HW_ANY, &available),
                ML_ERROR_INVALID_PARAMETER, "nnfw is not a value of ml_nnfw_type_e");
  CHECK_REFUSED(ml_check_nnfw_availability(ML_NNFW_TYPE_SNPE, ML_NNFW_HW_ANY, NULL),
                ML_ERROR_INVALID_PARAMETER, "available is a null pointer");
}

/* The engine is there, and its library is not. */
static void a_framework_without_its_library_is_not_available(void) {
  const char* const folder = getenv("WEIR_ENGINES_DIR");
  char* const before = folder ? strdup(folder) : NULL;
  bool available = true;
  setenv("WEIR_ENGINES_DIR", "/no/such/folder", 1);
  OK(ml_check_nnfw_availability(ML_NNFW_TYPE_TENSORFLOW_LITE, ML_NNFW_HW_ANY, &available));
  CHECK(!available);
  if (before)
    setenv("WEIR_ENGINES_DIR", before, 1);
  else
    unsetenv("WEIR_ENGINES_DIR");
  free(before);
}

int main(void) {
  a_framework_without_its_library_is_not_available();
  frames_go_in_and_come_out("appsrc name=in ! tensor_sink name=out sync=false");
  frames_go_in_and_come_out(
      "appsrc name=in ! tensor_transform mode=typecast option=float32 ! appsink name=out "
      "sync=false");
  states_follow_the_calls();
  a_flush_discards_frames_and_keeps_the_elements();
  a_frame_that_does_not_fit_its_caps_is_dropped();
  a_failed_element_is_the_error_of_the_state();
  callbacks_may_call();
  texts_and_names_are_refused();
  sinks_of_one_name_play_and_are_refused();
  frames_go_in_and_come_out(BIN
                            "bin.( fakesrc num-buffers=1 ! fakesink name=in ) "
                            "appsrc name=in ! tensor_sink name=out");
  a_pipeline_that_cannot_be_paused_is_refused();
  elements_and_frameworks_are_available();
  return result_of_checks();
}
