/* Tests of ml_pipeline_src_*. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <sys/resource.h>
#include <unistd.h>

#include "seen_test_support.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#endif

typedef struct {
  Counter frames;
  ml_tensor_type_e type;
  ml_tensor_dimension dimension;
} Described;

static void describe(const ml_tensors_data_h data, const ml_tensors_info_h info, void* user_data) {
  Described* described = user_data;
  (void)data;
  OK(ml_tensors_info_get_tensor_type(info, 0, &described->type));
  OK(ml_tensors_info_get_tensor_dimension(info, 0, described->dimension));
  raise_count(&described->frames);
}

/* Pushes before the start; the bytes of data count, not its type. */
static void frames_wait_for_the_start(void) {
  Seen seen = SEEN;
  ml_pipeline_h pipe = construct(
      "appsrc name=in ! "
      "other/tensors,format=static,num_tensors=1,dimensions=(string)2:1,types=float32,"
      "framerate=30/1 ! tensor_sink name=out sync=false");
  ml_tensors_info_h info = NULL, bytes = make_info(ML_TENSOR_TYPE_UINT8, 8, 0);
  ml_tensors_info_h few = make_info(ML_TENSOR_TYPE_UINT8, 7, 0);
  ml_tensor_dimension dimension;
  ml_tensor_type_e type = ML_TENSOR_TYPE_UNKNOWN;
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_tensors_data_h data = NULL;
  const float values[2] = {6, 7};
  unsigned int count = 0;
  OK(ml_pipeline_sink_register(pipe, "out", see, &seen, &sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_src_get_tensors_info(src, &info));
  OK(ml_tensors_info_get_count(info, &count));
  CHECK(count == 1);
  OK(ml_tensors_info_get_tensor_type(info, 0, &type));
  OK(ml_tensors_info_get_tensor_dimension(info, 0, dimension));
  CHECK(type == ML_TENSOR_TYPE_FLOAT32 && dimension[0] == 2);
  OK(ml_pipeline_src_input_data(src, two_floats(5), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_tensors_data_create(bytes, &data));
  OK(ml_tensors_data_set_tensor_data(data, 0, values, sizeof values));
  OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  CHECK(get_count(&seen.frames) == 0);
  OK(ml_pipeline_start(pipe));
  wait_for(&seen.frames, 2);
  CHECK(seen.last == 6);
  OK(ml_tensors_data_create(few, &data));
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_INVALID_PARAMETER, "tensor 0 does not match the caps of the appsrc");
  OK(ml_tensors_data_destroy(data)); /* it is still the program's */
  CHECK_REFUSED(ml_pipeline_src_get_tensors_info(src, NULL), ML_ERROR_INVALID_PARAMETER,
                "info is a null pointer");
  OK(ml_pipeline_destroy(pipe));
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_destroy(bytes));
  OK(ml_tensors_info_destroy(few));
}

static void count_frame(const ml_tensors_data_h data, const ml_tensors_info_h info,
                        void* user_data) {
  void* memory = NULL;
  size_t size = 0;
  (void)info;
  OK(ml_tensors_data_get_tensor_data(data, 0, &memory, &size));
  CHECK(size == 4);
  raise_count(user_data);
}

/* Caps that published programs have in the capsfilter after their appsrc, or in the appsrc. */
static void published_caps_take_data(void) {
  static const char* const caps[] = {
      "other/tensor,dimension=(string)4:1:1:1,type=(string)uint8,framerate=(fraction)0/1",
      "other/tensor,dimension=4:1:1:1,type=uint8,framerate=30/1",
      "other/tensors,format=static,num_tensors=1,dimensions=4:1:1:1,types=uint8,framerate=30/1",
      "other/tensors,format=flexible,framerate=30/1",
      "application/octet-stream",
      "text/x-raw,format=utf8",
      "video/x-raw,format=GRAY8,width=4,height=1,framerate=30/1"};
  enum { kCaps = sizeof caps / sizeof *caps };
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, 4, 1);
  size_t i;
  int frame;
  for (i = 0; i < 2 * kCaps; ++i) {
    Counter frames = COUNTER;
    char text[256];
    ml_pipeline_h pipe;
    ml_pipeline_src_h src = NULL;
    ml_pipeline_sink_h sink = NULL;
    ml_tensors_data_h data = NULL;
    snprintf(text, sizeof text,
             i < kCaps ? "appsrc name=in ! %s ! appsink name=out sync=false"
                       : "appsrc name=in caps=\"%s\" ! appsink name=out sync=false",
             caps[i % kCaps]);
    pipe = construct(text);
    OK(ml_pipeline_sink_register(pipe, "out", count_frame, &frames, &sink));
    OK(ml_pipeline_src_get_handle(pipe, "in", &src));
    OK(ml_pipeline_start(pipe));
    for (frame = 0; frame < 3; ++frame) {
      OK(ml_tensors_data_create(info, &data));
      OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
    }
    wait_for(&frames, 3);
    OK(ml_pipeline_destroy(pipe));
  }
  OK(ml_tensors_info_destroy(info));
}

typedef struct {
  Counter frames;
  unsigned int count;
  ml_tensor_type_e second;
} Pairs;

static void see_pair(const ml_tensors_data_h data, const ml_tensors_info_h info, void* user_data) {
  Pairs* pairs = user_data;
  (void)data;
  OK(ml_tensors_info_get_count(info, &pairs->count));
  OK(ml_tensors_info_get_tensor_type(info, 1, &pairs->second));
  raise_count(&pairs->frames);
}

static void caps_of_two_tensors_take_data(void) {
  static const char* const texts[] = {
      "appsrc name=in ! other/tensors,format=static,num_tensors=2,dimensions=(string)3.2,"
      "types=(string)uint8.float32,framerate=30/1 ! tensor_sink name=out sync=false",
      "appsrc name=in caps=other/tensors,format=static,num_tensors=2,dimensions=(string)3.2,"
      "types=(string)uint8.float32,framerate=0/1 ! tensor_sink name=out sync=false"};
  const ml_tensor_dimension three = {3}, two = {2};
  ml_tensors_info_h info = NULL, one = make_info(ML_TENSOR_TYPE_UINT8, 3, 0);
  size_t i;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_set_count(info, 2));
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UINT8));
  OK(ml_tensors_info_set_tensor_dimension(info, 0, three));
  OK(ml_tensors_info_set_tensor_type(info, 1, ML_TENSOR_TYPE_FLOAT32));
  OK(ml_tensors_info_set_tensor_dimension(info, 1, two));
  for (i = 0; i < sizeof texts / sizeof *texts; ++i) {
    Pairs pairs = {COUNTER, 0, ML_TENSOR_TYPE_UNKNOWN};
    ml_pipeline_h pipe = construct(texts[i]);
    ml_pipeline_src_h src = NULL;
    ml_pipeline_sink_h sink = NULL;
    ml_tensors_data_h data = NULL;
    OK(ml_pipeline_sink_register(pipe, "out", see_pair, &pairs, &sink));
    OK(ml_pipeline_src_get_handle(pipe, "in", &src));
    OK(ml_pipeline_start(pipe));
    OK(ml_tensors_data_create(info, &data));
    OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
    wait_for(&pairs.frames, 1);
    CHECK(pairs.count == 2 && pairs.second == ML_TENSOR_TYPE_FLOAT32);
    OK(ml_tensors_data_create(one, &data));
    CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                  ML_ERROR_INVALID_PARAMETER, "a different number of tensors");
    OK(ml_tensors_data_destroy(data));
    OK(ml_pipeline_destroy(pipe));
  }
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_destroy(one));
}

static void media_and_open_caps_name_no_tensors(void) {
  static const char* const texts[] = {
      "appsrc name=in ! video/x-raw,format=RGB,width=4,height=4,framerate=30/1 ! fakesink",
      "appsrc name=in ! other/tensors,format=flexible,framerate=30/1 ! fakesink",
      "appsrc name=in ! application/octet-stream ! fakesink", "appsrc name=in ! tensor_sink"};
  size_t i;
  for (i = 0; i < sizeof texts / sizeof *texts; ++i) {
    ml_pipeline_h pipe = construct(texts[i]);
    ml_pipeline_src_h src = NULL;
    ml_tensors_info_h info = NULL;
    unsigned int count = 9;
    OK(ml_pipeline_src_get_handle(pipe, "in", &src));
    OK(ml_pipeline_src_get_tensors_info(src, &info));
    OK(ml_tensors_info_get_count(info, &count));
    CHECK(count == 0);
    OK(ml_tensors_info_destroy(info));
    OK(ml_pipeline_destroy(pipe));
  }
}

typedef struct {
  Counter needs, enoughs;
  ml_pipeline_src_h src;
} Requests;

static void need(ml_pipeline_src_h src, unsigned int length, void* user_data) {
  Requests* requests = user_data;
  (void)length;
  CHECK(src == requests->src);
  raise_count(&requests->needs);
}

static void enough(ml_pipeline_src_h src, void* user_data) {
  Requests* requests = user_data;
  CHECK(src == requests->src);
  raise_count(&requests->enoughs);
}

static void a_source_asks_for_data(void) {
  Requests requests = {COUNTER, COUNTER, NULL}, other = {COUNTER, COUNTER, NULL};
  ml_pipeline_src_callbacks_s functions = {need, enough, NULL}, none = {NULL, NULL, NULL};
  ml_pipeline_h pipe = construct("appsrc name=in max-buffers=1 ! tensor_sink sync=false");
  ml_pipeline_src_h src = NULL;
  int i;
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  requests.src = other.src = src;
  CHECK_REFUSED(ml_pipeline_src_set_event_cb(src, NULL, &requests), ML_ERROR_INVALID_PARAMETER,
                "cb is a null pointer");
  CHECK_REFUSED(ml_pipeline_src_set_event_cb(NULL, &functions, &requests),
                ML_ERROR_INVALID_PARAMETER, "src_handle is a null pointer");
  OK(ml_pipeline_src_set_event_cb(src, &functions, &other));
  OK(ml_pipeline_src_set_event_cb(src, &functions, &requests)); /* replaces the one before */
  functions = none;                                             /* it was copied */
  for (i = 0; i < 3; ++i)
    OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&requests.enoughs, 1);
  OK(ml_pipeline_start(pipe));
  wait_for(&requests.needs, 1);
  /* Also after a flush. */
  OK(ml_pipeline_flush(pipe, true));
  i = get_count(&requests.needs);
  OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  wait_for(&requests.needs, i + 1);
  OK(ml_pipeline_src_release_handle(src));
  i = get_count(&requests.needs);
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  OK(ml_pipeline_destroy(pipe));
  CHECK(get_count(&requests.needs) == i);
  /* Calls between the two registrations are possible, none afterwards. */
  CHECK(get_count(&other.needs) <= 1 && get_count(&other.enoughs) == 0);
}

/* The caps are those of each frame where nothing after the source fixes them. */
static void frames_of_one_size_keep_their_own_layout(void) {
  Described described = {COUNTER, ML_TENSOR_TYPE_UNKNOWN, {0}};
  ml_pipeline_h pipe = construct("appsrc name=in ! tensor_sink name=out sync=false");
  ml_tensors_info_h infos[2] = {make_info(ML_TENSOR_TYPE_FLOAT32, 2, 3),
                                make_info(ML_TENSOR_TYPE_INT16, 4, 3)};
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_tensors_info_h got = NULL;
  unsigned int count = 9;
  int i;
  OK(ml_pipeline_sink_register(pipe, "out", describe, &described, &sink));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  OK(ml_pipeline_start(pipe));
  for (i = 0; i < 4; ++i) {
    ml_tensors_data_h data = NULL;
    OK(ml_tensors_data_create(infos[i % 2], &data));
    OK(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
    wait_for(&described.frames, i + 1);
    CHECK(described.type == (i % 2 ? ML_TENSOR_TYPE_INT16 : ML_TENSOR_TYPE_FLOAT32));
    CHECK(described.dimension[0] == (i % 2 ? 4 : 2) && described.dimension[1] == 3);
    OK(ml_pipeline_src_get_tensors_info(src, &got));
    OK(ml_tensors_info_get_count(got, &count));
    CHECK(count == 0);
    OK(ml_tensors_info_destroy(got));
  }
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(pipe));
  for (i = 0; i < 2; ++i) OK(ml_tensors_info_destroy(infos[i]));
}

/* What a callback for `enough_data` calls, which a push of the program's runs. */
typedef struct {
  Counter calls;
  ml_tensors_data_h same, other;
} Inner;

static void push_from_within(ml_pipeline_src_h src, void* user_data) {
  Inner* inner = user_data;
  ml_tensors_info_h info = NULL;
  unsigned int count = 9;
  raise_count(&inner->calls);
  if (get_count(&inner->calls) > 1) return; /* of its own push */
  OK(ml_pipeline_src_get_tensors_info(src, &info));
  OK(ml_tensors_info_get_count(info, &count));
  CHECK(count == 0);
  OK(ml_tensors_info_destroy(info));
  OK(ml_pipeline_src_input_data(src, inner->same, ML_PIPELINE_BUF_POLICY_AUTO_FREE));
  CHECK_REFUSED(ml_pipeline_src_input_data(src, inner->other, ML_PIPELINE_BUF_POLICY_DO_NOT_FREE),
                ML_ERROR_TRY_AGAIN, "a push on this thread waits for a callback");
  OK(ml_pipeline_src_input_data(src, NULL, ML_PIPELINE_BUF_SRC_EVENT_EOS));
}

static void a_source_that_has_enough_takes_calls(void) {
  static const char* const texts[] = {
      "appsrc name=in max-buffers=1 ! tensor_sink",
      "appsrc name=in max-buffers=1 block=true ! queue ! tensor_sink"};
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, 7, 0);
  size_t i;
  for (i = 0; i < sizeof texts / sizeof *texts; ++i) {
    ml_pipeline_src_callbacks_s functions = {NULL, push_from_within, NULL};
    Inner inner = {COUNTER, two_floats(2), NULL};
    ml_pipeline_h pipe = construct(texts[i]);
    ml_pipeline_src_h src = NULL;
    int result = ML_ERROR_NONE;
    OK(ml_tensors_data_create(info, &inner.other));
    OK(ml_pipeline_src_get_handle(pipe, "in", &src));
    OK(ml_pipeline_src_set_event_cb(src, &functions, &inner));
    if (i > 0) OK(ml_pipeline_start(pipe));
    while (result == ML_ERROR_NONE)
      result = ml_pipeline_src_input_data(src, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE);
    CHECK(result == ML_ERROR_STREAMS_PIPE); /* the callback has ended the stream */
    CHECK(get_count(&inner.calls) > 0);
    OK(ml_pipeline_src_release_handle(src));
    OK(ml_pipeline_destroy(pipe));
    OK(ml_tensors_data_destroy(inner.other));
  }
  OK(ml_tensors_info_destroy(info));
}

typedef struct {
  Counter entered, released, finished;
  ml_pipeline_src_h src;
} Held;

static void hold_until_released(ml_pipeline_src_h src, void* user_data) {
  Held* held = user_data;
  (void)src;
  raise_count(&held->entered);
  wait_for(&held->released, 1);
  raise_count(&held->finished);
}

static void* push_until_released(void* data) {
  int result = ML_ERROR_NONE;
  while (result == ML_ERROR_NONE)
    result = ml_pipeline_src_input_data(data, two_floats(1), ML_PIPELINE_BUF_POLICY_AUTO_FREE);
  CHECK(result == ML_ERROR_INVALID_PARAMETER);
  return NULL;
}

static int is_open(ml_pipeline_src_h src) {
  ml_tensors_info_h info = NULL;
  const int result = ml_pipeline_src_get_tensors_info(src, &info);
  if (result == ML_ERROR_NONE) OK(ml_tensors_info_destroy(info));
  return result == ML_ERROR_NONE;
}

static void* release_it(void* data) {
  Held* held = data;
  OK(ml_pipeline_src_release_handle(held->src));
  CHECK(get_count(&held->finished) == 1);
  return NULL;
}

/* Also where a call on another thread keeps the source. */
static void a_release_waits_for_the_callback(void) {
  Held held = {COUNTER, COUNTER, COUNTER, NULL};
  ml_pipeline_src_callbacks_s functions = {NULL, hold_until_released, NULL};
  ml_pipeline_h pipe = construct("appsrc name=in max-buffers=1 ! tensor_sink");
  pthread_t pushing, releasing;
  int i;
  OK(ml_pipeline_src_get_handle(pipe, "in", &held.src));
  OK(ml_pipeline_src_set_event_cb(held.src, &functions, &held));
  CHECK(pthread_create(&pushing, NULL, push_until_released, held.src) == 0);
  wait_for(&held.entered, 1);
  CHECK(pthread_create(&releasing, NULL, release_it, &held) == 0);
  for (i = 0; i < 1000; ++i) /* until the release has begun */
    while (is_open(held.src)) {
    }
  raise_count(&held.released);
  pthread_join(releasing, NULL);
  pthread_join(pushing, NULL);
  OK(ml_pipeline_destroy(pipe));
}

/* Pushing copies the memory of the data, for which there is no room here. */
static void data_belongs_to_the_library_after_other_errors(void) {
#ifndef SANITIZED
  enum { kBytes = 64 << 20 };
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_UINT8, kBytes, 0);
  ml_pipeline_h pipe = construct("appsrc name=in ! tensor_sink");
  ml_tensors_data_h data = NULL;
  ml_pipeline_src_h src = NULL;
  struct rlimit before, low;
  long pages = 0;
  int result;
  FILE* file = fopen("/proc/self/statm", "r");
  CHECK(file && fscanf(file, "%ld", &pages) == 1);
  if (file) fclose(file);
  OK(ml_tensors_data_create(info, &data));
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  CHECK(getrlimit(RLIMIT_AS, &before) == 0);
  low = before;
  low.rlim_cur = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + kBytes + kBytes / 2;
  CHECK(setrlimit(RLIMIT_AS, &low) == 0);
  result = ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE);
  CHECK(setrlimit(RLIMIT_AS, &before) == 0);
  CHECK(result == ML_ERROR_OUT_OF_MEMORY);
  CHECK_REFUSED(ml_tensors_data_destroy(data), ML_ERROR_INVALID_PARAMETER, "was destroyed");
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(pipe));
  OK(ml_tensors_info_destroy(info));
#endif
}

static void a_source_without_caps_can_be_tried_again(void) {
  ml_pipeline_h pipe = construct("appsrc name=in  videotestsrc ! fakesink");
  ml_tensors_data_h data = two_floats(1);
  ml_tensors_info_h info = NULL;
  ml_pipeline_src_h src = NULL;
  OK(ml_pipeline_src_get_handle(pipe, "in", &src));
  CHECK_REFUSED(ml_pipeline_src_get_tensors_info(src, &info), ML_ERROR_TRY_AGAIN,
                "the appsrc in has no caps");
  CHECK(info == NULL);
  CHECK_REFUSED(ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE),
                ML_ERROR_TRY_AGAIN, "the appsrc in has no caps");
  OK(ml_tensors_data_destroy(data));
  OK(ml_pipeline_src_release_handle(src));
  OK(ml_pipeline_destroy(pipe));
}

int main(void) {
  frames_wait_for_the_start();
  published_caps_take_data();
  caps_of_two_tensors_take_data();
  media_and_open_caps_name_no_tensors();
  a_source_asks_for_data();
  frames_of_one_size_keep_their_own_layout();
  a_source_that_has_enough_takes_calls();
  a_release_waits_for_the_callback();
  data_belongs_to_the_library_after_other_errors();
  a_source_without_caps_can_be_tried_again();
  return result_of_checks();
}
