/* Tests filters and conditions of the program, the elements that the configuration allows, and many
 * concurrent threads.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <sys/stat.h>
#include <unistd.h>

#include "check_test_support.h"
#include "nnstreamer-single.h"
#include "nnstreamer.h"
#include "wait_test_support.h"

static int invokes;

/* y = 2 x; drops x = 13, fails with x = 99. */
static int twice(const ml_tensors_data_h in, ml_tensors_data_h out, void* user_data) {
  void* x = NULL;
  float y[2];
  size_t size = 0;
  ++*(int*)user_data;
  OK(ml_tensors_data_get_tensor_data(in, 0, &x, &size));
  CHECK(size == sizeof y);
  if (((float*)x)[0] == 13) return 1;
  if (((float*)x)[0] == 99) return -5;
  y[0] = 2 * ((float*)x)[0];
  y[1] = 2 * ((float*)x)[1];
  CHECK(ml_tensors_data_set_tensor_data(in, 0, y, sizeof y) == ML_ERROR_PERMISSION_DENIED);
  OK(ml_tensors_data_set_tensor_data(out, 0, y, sizeof y));
  return 0;
}

typedef struct {
  Counter frames;
  float last;
} Seen;

static void see(const ml_tensors_data_h data, const ml_tensors_info_h info, void* user_data) {
  Seen* seen = user_data;
  const float* values = floats(data, 0, 2);
  (void)info;
  seen->last = values ? values[0] : -1;
  raise_count(&seen->frames);
}

static void a_filter_of_the_program_runs(void) {
  Seen seen = {COUNTER, 0};
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 0), empty = NULL;
  ml_custom_easy_filter_h filter = NULL, second = NULL;
  ml_pipeline_h pipe = NULL;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_pipeline_state_e state;
  ml_tensors_data_h data = NULL;
  int result = ML_ERROR_NONE;
  OK(ml_tensors_info_create(&empty));
  OK(ml_pipeline_custom_easy_filter_register("twice", info, info, twice, &invokes, &filter));
  CHECK_REFUSED(
      ml_pipeline_custom_easy_filter_register("twice", info, info, twice, &invokes, &second),
      ML_ERROR_INVALID_PARAMETER, "twice");
  CHECK_REFUSED(
      ml_pipeline_custom_easy_filter_register("auto", info, info, twice, &invokes, &second),
      ML_ERROR_INVALID_PARAMETER, "not auto or any");
  CHECK_REFUSED(
      ml_pipeline_custom_easy_filter_register("other", empty, info, twice, &invokes, &second),
      ML_ERROR_INVALID_PARAMETER, "in describes no tensor");
  CHECK_REFUSED(
      ml_pipeline_custom_easy_filter_register("other", info, info, NULL, &invokes, &second),
      ML_ERROR_INVALID_PARAMETER, "null pointer");
  CHECK(second == NULL);
  OK(
      ml_pipeline_construct("appsrc name=in ! tensor_filter framework=custom-easy model=twice ! "
                            "tensor_sink name=out sync=false",
                            NULL, NULL, &pipe));
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  OK(ml_pipeline_src_input_data(src, two_floats(3), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 1);
  CHECK(seen.last == 6);
  OK(ml_pipeline_src_input_data(src, two_floats(13), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_src_input_data(src, two_floats(4), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 2);
  CHECK(seen.last == 8 && invokes == 3);
  data = two_floats(99);
  while (result == ML_ERROR_NONE)
    result = ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE);
  OK(ml_tensors_data_destroy(data));
  CHECK_REFUSED(ml_pipeline_get_state(pipe, &state), ML_ERROR_STREAMS_PIPE,
                "the callback of twice returned -5");
  CHECK_REFUSED(ml_pipeline_custom_easy_filter_unregister(filter), ML_ERROR_INVALID_PARAMETER,
                "a pipeline uses the callback, which stays registered\n  offered: \"twice\"");
  OK(ml_pipeline_destroy(pipe));
  OK(ml_pipeline_custom_easy_filter_unregister(filter));
  CHECK_REFUSED(ml_pipeline_custom_easy_filter_unregister(filter), ML_ERROR_INVALID_PARAMETER,
                "custom is a handle that was destroyed or released");
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_destroy(empty));
}

static void a_filter_that_is_unregistered_is_called_no_more(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 0);
  ml_custom_easy_filter_h filter = NULL;
  ml_single_h single = NULL;
  ml_tensors_data_h data = two_floats(1), out = NULL;
  const int before = invokes;
  OK(ml_pipeline_custom_easy_filter_register("gone", info, info, twice, &invokes, &filter));
  OK(ml_single_open(&single, "gone", NULL, NULL, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY));
  OK(ml_single_invoke(single, data, &out));
  OK(ml_tensors_data_destroy(out));
  OK(ml_pipeline_custom_easy_filter_unregister(filter));
  CHECK_REFUSED(ml_single_invoke(single, data, &out), ML_ERROR_STREAMS_PIPE,
                "the callback of gone is no longer registered");
  CHECK(invokes == before + 1);
  OK(ml_single_close(single));
  OK(ml_tensors_data_destroy(data));
  OK(ml_tensors_info_destroy(info));
}

static ml_pipeline_h destroyed;

static int destroying(const ml_tensors_data_h in, ml_tensors_data_h out, void* user_data) {
  (void)in;
  (void)out;
  CHECK_REFUSED(ml_pipeline_destroy(destroyed), ML_ERROR_TRY_AGAIN,
                "a callback cannot change the state of its own pipeline");
  CHECK_REFUSED(ml_pipeline_flush(destroyed, true), ML_ERROR_TRY_AGAIN, "a call on another thread");
  raise_count(user_data);
  return 0;
}

/* On a streaming thread: the pipeline would wait for the callback, and the callback for the
 * pipeline. */
static void a_filter_cannot_destroy_its_pipeline(void) {
  Counter calls = COUNTER;
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 0);
  ml_custom_easy_filter_h filter = NULL;
  ml_pipeline_src_h src = NULL;
  OK(ml_pipeline_custom_easy_filter_register("destroying", info, info, destroying, &calls,
                                             &filter));
  OK(
      ml_pipeline_construct("appsrc name=in ! tensor_filter framework=custom-easy model=destroying "
                            "! tensor_sink",
                            NULL, NULL, &destroyed));
  OK(ml_pipeline_src_get_handle(destroyed, "in", &src));
  OK(ml_pipeline_start(destroyed));
  OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&calls, 1);
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(destroyed));
  OK(ml_pipeline_custom_easy_filter_unregister(filter));
  OK(ml_tensors_info_destroy(info));
}

static int positive(const ml_tensors_data_h data, const ml_tensors_info_h info, int* result,
                    void* user_data) {
  const float* values = floats(data, 0, 2);
  unsigned int count = 0;
  (void)user_data;
  OK(ml_tensors_info_get_count(info, &count));
  CHECK(count == 1);
  *result = values && values[0] > 0;
  return 0;
}

static void a_condition_of_the_program_decides(void) {
  Seen seen = {COUNTER, 0};
  ml_pipeline_if_h condition = NULL, second = NULL;
  ml_pipeline_h pipe = NULL;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  OK(ml_pipeline_tensor_if_custom_register("positive", positive, NULL, &condition));
  CHECK_REFUSED(ml_pipeline_tensor_if_custom_register("positive", positive, NULL, &second),
                ML_ERROR_INVALID_PARAMETER, "cannot be registered under this name");
  CHECK_REFUSED(ml_pipeline_tensor_if_custom_register("", positive, NULL, &second),
                ML_ERROR_INVALID_PARAMETER, "needed: a non-empty name that no other condition has");
  CHECK_REFUSED(ml_pipeline_tensor_if_custom_register("x", NULL, NULL, &second),
                ML_ERROR_INVALID_PARAMETER, "null pointer");
  OK(ml_pipeline_construct(
      "appsrc name=in ! tensor_if name=i compared-value=CUSTOM compared-value-option=positive "
      "then=PASSTHROUGH else=SKIP i.src_0 ! tensor_sink name=out sync=false async=false",
      NULL, NULL, &pipe));
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  OK(ml_pipeline_src_input_data(src, two_floats(5), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_src_input_data(src, two_floats(-6), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_src_input_data(src, two_floats(7), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&seen.frames, 2);
  CHECK(seen.last == 7);
  CHECK_REFUSED(ml_pipeline_tensor_if_custom_unregister(condition), ML_ERROR_INVALID_PARAMETER,
                "a pipeline uses the callback");
  OK(ml_pipeline_destroy(pipe));
  OK(ml_pipeline_tensor_if_custom_unregister(condition));
  CHECK_REFUSED(ml_pipeline_tensor_if_custom_unregister(condition), ML_ERROR_INVALID_PARAMETER,
                "if_custom is a handle that was destroyed or released");
}

static int return_seven(const ml_tensors_data_h data, const ml_tensors_info_h info, int* result,
                        void* user_data) {
  (void)data, (void)info, (void)user_data;
  *result = 1;
  return 7;
}

static void a_condition_that_returns_a_number_fails(void) {
  ml_pipeline_if_h condition = NULL;
  ml_pipeline_h pipe = NULL;
  ml_pipeline_src_h src = NULL;
  int result = ML_ERROR_NONE;
  OK(ml_pipeline_tensor_if_custom_register("seven", return_seven, NULL, &condition));
  OK(ml_pipeline_construct(
      "appsrc name=in ! tensor_if name=i compared-value=CUSTOM compared-value-option=seven "
      "then=PASSTHROUGH else=SKIP i.src_0 ! tensor_sink async=false",
      NULL, NULL, &pipe));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  while (result == ML_ERROR_NONE)
    result = ml_pipeline_src_input_data(src, two_floats(5), ML_PIPELINE_BUF_POLICY_AUTO_FREE);
  CHECK(result == ML_ERROR_STREAMS_PIPE);
  CHECK(strstr(last_error(), "the callback of seven returned 7"));
  OK(ml_pipeline_destroy(pipe));
  OK(ml_pipeline_tensor_if_custom_unregister(condition));
}

static void write_configuration(const char* path, const char* text) {
  FILE* file = fopen(path, "w");
  CHECK(file != NULL);
  if (!file) return;
  fputs(text, file);
  fclose(file);
}

/* What the construction of a pipeline writes to standard error. */
static const char* state_at_construction(void) {
  static char text[2000];
  FILE* file = tmpfile();
  const int was = dup(STDERR_FILENO);
  ml_pipeline_h pipe = NULL;
  size_t bytes;
  CHECK(file && was >= 0);
  fflush(stderr);
  dup2(fileno(file), STDERR_FILENO);
  OK(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe));
  fflush(stderr);
  dup2(was, STDERR_FILENO);
  close(was);
  OK(ml_pipeline_destroy(pipe));
  rewind(file);
  bytes = fread(text, 1, sizeof text - 1, file);
  text[bytes] = '\0';
  fclose(file);
  return text;
}

/* Runs as another user if the test runs as root, who may read every file. */
static void elements_with_a_configuration_out_of_reach(void) {
  char folder[] = "/tmp/weir-closed-XXXXXX", path[64], open_path[64];
  const char* home = getenv("HOME");
  const int root = geteuid() == 0;
  ml_pipeline_h pipe = NULL;
  CHECK(mkdtemp(folder) != NULL);
  snprintf(path, sizeof path, "%s/nnstreamer.ini", folder);
  snprintf(open_path, sizeof open_path, "%s.ini", folder);
  write_configuration(path,
                      "[element-restriction]\nenable_element_restriction=1\n"
                      "allowed_elements=videotestsrc,fakesink\n");
  write_configuration(open_path, "[common]\nenable_envvar=no\n");
  CHECK(chmod(open_path, 0644) == 0 && chmod(folder, 0) == 0);
  CHECK(!root || seteuid(65534) == 0);
  setenv("WEIR_NNSTREAMER_ENABLE", "yes", 1);
  setenv("NNSTREAMER_CONF", path, 1);
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe),
                ML_ERROR_PERMISSION_DENIED,
                "a pipeline cannot be checked against [element-restriction]");
  CHECK(strstr(last_error(), "Permission denied"));
  /* A home folder out of reach holds no restriction. */
  setenv("NNSTREAMER_CONF", open_path, 1);
  setenv("HOME", folder, 1);
  unsetenv("WEIR_CONFIG");
  OK(ml_pipeline_construct("videotestsrc ! identity ! fakesink", NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  CHECK(!root || seteuid(0) == 0);
  CHECK(chmod(folder, 0700) == 0);
  unlink(path);
  unlink(open_path);
  rmdir(folder);
  if (home) setenv("HOME", home, 1);
  setenv("WEIR_CONFIG", "", 1);
  unsetenv("NNSTREAMER_CONF");
}

static void only_elements_that_are_allowed(void) {
  char path[] = "/tmp/weir-restriction-XXXXXX";
  const int descriptor = mkstemp(path);
  bool available = false;
  ml_pipeline_h pipe = NULL;
  CHECK(descriptor >= 0);
  close(descriptor);
  setenv("WEIR_NNSTREAMER_ENABLE", "yes", 1);
  setenv("NNSTREAMER_CONF", path, 1);
  write_configuration(path,
                      "[element-restriction]\nenable_element_restriction=1\n"
                      "allowed_elements=videotestsrc,fakesink\n");
  OK(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! filesink name=f", NULL, NULL, &pipe),
                ML_ERROR_NOT_SUPPORTED,
                "the configuration does not allow this element in pipelines\n"
                "  offered: filesink\n"
                "  needed: an element of NNStreamer, or one of: videotestsrc, fakesink\n"
                "  fix: add the element to allowed_elements of [element-restriction] in "
                "/tmp/weir-restriction-");
  CHECK(pipe == NULL);
  CHECK_REFUSED(ml_pipeline_construct("( videotestsrc ! identity ! fakesink )", NULL, NULL, &pipe),
                ML_ERROR_NOT_SUPPORTED, "offered: bin");
  CHECK_REFUSED(ml_pipeline_construct("file:///etc/hostname ! fakesink", NULL, NULL, &pipe),
                ML_ERROR_NOT_SUPPORTED, "offered: filesrc");
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! nosuchelement", NULL, NULL, &pipe),
                ML_ERROR_STREAMS_PIPE, "nosuchelement");
  /* Caps and parentheses of the text are elements too. */
  CHECK_REFUSED(
      ml_pipeline_construct("videotestsrc ! video/x-raw,width=8 ! fakesink", NULL, NULL, &pipe),
      ML_ERROR_NOT_SUPPORTED, "offered: capsfilter");
  CHECK_REFUSED(ml_pipeline_construct("( videotestsrc ! fakesink )", NULL, NULL, &pipe),
                ML_ERROR_NOT_SUPPORTED, "offered: bin");
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! ", NULL, NULL, &pipe), ML_ERROR_STREAMS_PIPE,
                "WEIR-");
  CHECK(pipe == NULL);
  OK(ml_check_element_availability("fakesink", &available));
  CHECK(available);
  OK(ml_check_element_availability("tensor_filter", &available));
  CHECK(available);
  available = true;
  OK(ml_check_element_availability("filesink", &available));
  CHECK(!available);
  /* Names compare without case. Elements of NNStreamer, and those that bins add, need no entry. */
  write_configuration(path,
                      "[element-restriction]\nenable_element_restriction=true\n"
                      "allowed_elements=VideoTestSrc FakeSink;CAPSFILTER bin,filesrc decodebin\n");
  OK(
      ml_pipeline_construct("( videotestsrc ! video/x-raw,format=RGB,width=8 ! tensor_converter ! "
                            "fakesink )",
                            NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  /* Children of a bin need no entry. */
  OK(ml_pipeline_construct("( name=b videotestsrc ! identity ! fakesink )", NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  OK(ml_pipeline_construct("bin.( videotestsrc ! identity ! fakesink )", NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  OK(ml_check_element_availability("decodebin", &available));
  if (available) {
    OK(ml_pipeline_construct("filesrc location=/etc/hostname ! decodebin ! fakesink", NULL, NULL,
                             &pipe));
    OK(ml_pipeline_destroy(pipe));
  }
  write_configuration(path, "[element-restriction]\nenable_element_restriction=true\n");
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe),
                ML_ERROR_NOT_SUPPORTED, "needed: an element of NNStreamer\n");
  /* An unreadable file may contain a restriction. */
  write_configuration(path, "[element-restriction]\nenable_element_restriction\n");
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe),
                ML_ERROR_PERMISSION_DENIED,
                "a pipeline cannot be checked against [element-restriction]: "
                "/tmp/weir-restriction-");
  setenv("NNSTREAMER_CONF", "/proc/self/mem", 1); /* opens but cannot be read, even by root */
  CHECK_REFUSED(ml_pipeline_construct("videotestsrc ! fakesink", NULL, NULL, &pipe),
                ML_ERROR_PERMISSION_DENIED, "/proc/self/mem");
  setenv("NNSTREAMER_CONF", path, 1);
  write_configuration(path,
                      "[element-restriction]\nenable_element_restriction=0\n"
                      "allowed_elements=videotestsrc,fakesink\n");
  OK(ml_pipeline_construct("videotestsrc ! identity ! fakesink", NULL, NULL, &pipe));
  OK(ml_pipeline_destroy(pipe));
  unlink(path);
  CHECK(strstr(state_at_construction(),
               "NNSTREAMER_CONF does not name a regular file and is ignored"));
  CHECK(strcmp(state_at_construction(), "") == 0); /* reported only once */
  unsetenv("NNSTREAMER_CONF");
}

static void* push_until_destroyed(void* src) {
  int result = ML_ERROR_NONE;
  ml_tensors_data_h data = two_floats(1);
  while (result == ML_ERROR_NONE || result == ML_ERROR_TRY_AGAIN)
    result = ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE);
  CHECK(strstr(last_error(), "destroyed"));
  OK(ml_tensors_data_destroy(data));
  return NULL;
}

static void a_pipeline_is_destroyed_under_busy_threads(void) {
  enum { kThreads = 4 };
  pthread_t threads[kThreads];
  Seen seen = {COUNTER, 0};
  ml_pipeline_h pipe = NULL;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  int i;
  OK(ml_pipeline_construct(
      "appsrc name=in block=true max-buffers=2 ! queue ! tensor_sink name=out "
      "sync=false",
      NULL, NULL, &pipe));
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  for (i = 0; i < kThreads; ++i)
    CHECK(pthread_create(&threads[i], NULL, push_until_destroyed, src) == 0);
  wait_for(&seen.frames, 50);
  OK(ml_pipeline_destroy(pipe));
  for (i = 0; i < kThreads; ++i) pthread_join(threads[i], NULL);
  i = get_count(&seen.frames);
  CHECK_REFUSED(ml_pipeline_sink_unregister(sink), ML_ERROR_INVALID_PARAMETER, "was destroyed");
  CHECK(get_count(&seen.frames) == i);
}

typedef struct {
  pthread_barrier_t begin;
  ml_custom_easy_filter_h filter;
  int result;
} Unregistering;

static void* unregister_it(void* data) {
  Unregistering* other = data;
  pthread_barrier_wait(&other->begin);
  other->result = ml_pipeline_custom_easy_filter_unregister(other->filter);
  return NULL;
}

/* A pipeline has its filter for its whole life, or is not constructed. */
static void a_filter_is_unregistered_or_used(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 0);
  int round;
  for (round = 0; round < 100; ++round) {
    Unregistering other;
    ml_pipeline_h pipe = NULL;
    pthread_t thread;
    int result;
    CHECK(pthread_barrier_init(&other.begin, NULL, 2) == 0);
    OK(ml_pipeline_custom_easy_filter_register("raced", info, info, twice, &invokes,
                                               &other.filter));
    CHECK(pthread_create(&thread, NULL, unregister_it, &other) == 0);
    pthread_barrier_wait(&other.begin);
    result = ml_pipeline_construct(
        "appsrc ! tensor_filter framework=custom-easy model=raced ! fakesink", NULL, NULL, &pipe);
    pthread_join(thread, NULL);
    CHECK(result == ML_ERROR_NONE ? other.result == ML_ERROR_INVALID_PARAMETER
                                  : result == ML_ERROR_STREAMS_PIPE);
    if (result == ML_ERROR_NONE) OK(ml_pipeline_destroy(pipe));
    if (other.result != ML_ERROR_NONE) OK(ml_pipeline_custom_easy_filter_unregister(other.filter));
    pthread_barrier_destroy(&other.begin);
  }
  OK(ml_tensors_info_destroy(info));
}

int main(void) {
  a_filter_of_the_program_runs();
  a_filter_that_is_unregistered_is_called_no_more();
  a_filter_cannot_destroy_its_pipeline();
  a_condition_of_the_program_decides();
  a_condition_that_returns_a_number_fails();
  only_elements_that_are_allowed();
  elements_with_a_configuration_out_of_reach();
  a_pipeline_is_destroyed_under_busy_threads();
  a_filter_is_unregistered_or_used();
  return result_of_checks();
}
