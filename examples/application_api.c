/* A program on NNStreamer's application API that registers its own filter and uses it alone and in
 * a pipeline.
 *
 *   application_api 'tensor_filter framework=custom-easy model=twice'
 *   cc -std=c11 application_api.c $(pkg-config --cflags --libs capi-ml-inference)
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <nnstreamer-single.h>
#include <nnstreamer.h>
#include <pthread.h>
#include <stdio.h>
#include <time.h>

enum { kFrames = 3 };

typedef struct {
  pthread_mutex_t mutex;
  pthread_cond_t changed;
  int count;
} Arrived;

static int complain(void) {
  fprintf(stderr, "%s\n", ml_error());
  return 1;
}

static int twice(const ml_tensors_data_h in, ml_tensors_data_h out, void* user_data) {
  void *x = NULL, *y = NULL;
  size_t size = 0, i;
  (void)user_data;
  if (ml_tensors_data_get_tensor_data(in, 0, &x, &size) < 0) return -1;
  if (ml_tensors_data_get_tensor_data(out, 0, &y, &size) < 0) return -1;
  for (i = 0; i < size / sizeof(float); ++i) ((float*)y)[i] = 2 * ((const float*)x)[i];
  return 0;
}

static int print(ml_tensors_data_h data) {
  void* memory = NULL;
  size_t size = 0, i;
  if (ml_tensors_data_get_tensor_data(data, 0, &memory, &size) < 0) return complain();
  for (i = 0; i < size / sizeof(float); ++i) printf("%g ", ((const float*)memory)[i]);
  printf("\n");
  fflush(stdout);
  return 0;
}

static void on_frame(const ml_tensors_data_h data, const ml_tensors_info_h info, void* user_data) {
  Arrived* arrived = user_data;
  (void)info;
  print(data);
  pthread_mutex_lock(&arrived->mutex);
  ++arrived->count;
  pthread_cond_signal(&arrived->changed);
  pthread_mutex_unlock(&arrived->mutex);
}

/* Returns when every frame has arrived or an element has failed. */
static int wait_for_frames(ml_pipeline_h pipe, Arrived* arrived) {
  ml_pipeline_state_e state;
  int count = 0;
  while (count < kFrames) {
    struct timespec soon;
    if (ml_pipeline_get_state(pipe, &state) < 0) return complain();
    timespec_get(&soon, TIME_UTC);
    ++soon.tv_sec; /* wakes up to check the state again */
    pthread_mutex_lock(&arrived->mutex);
    if (arrived->count < kFrames) pthread_cond_timedwait(&arrived->changed, &arrived->mutex, &soon);
    count = arrived->count;
    pthread_mutex_unlock(&arrived->mutex);
  }
  return 0;
}

/* Makes two values, `first` and 0.5. */
static int make_data(ml_tensors_info_h info, float first, ml_tensors_data_h* data) {
  const float values[2] = {first, 0.5f};
  const int result = ml_tensors_data_create(info, data);
  return result < 0 ? result : ml_tensors_data_set_tensor_data(*data, 0, values, sizeof values);
}

static int run_once(ml_tensors_info_h info) {
  ml_single_h single = NULL;
  ml_tensors_data_h in = NULL, out = NULL;
  int failed = 1;
  if (ml_single_open(&single, "twice", info, info, ML_NNFW_TYPE_CUSTOM_FILTER, ML_NNFW_HW_ANY) < 0)
    return complain();
  if (make_data(info, 21, &in) < 0 || ml_single_invoke(single, in, &out) < 0)
    complain();
  else
    failed = print(out);
  if (out) ml_tensors_data_destroy(out);
  if (in) ml_tensors_data_destroy(in);
  ml_single_close(single);
  return failed;
}

static int push_frames(ml_pipeline_h pipe, ml_tensors_info_h info, Arrived* arrived) {
  ml_pipeline_src_h src = NULL;
  ml_pipeline_sink_h sink = NULL;
  ml_tensors_data_h data = NULL;
  int i, failed = 0;
  if (ml_pipeline_sink_register(pipe, "out", on_frame, arrived, &sink) < 0 ||
      ml_pipeline_src_get_handle(pipe, "in", &src) < 0 || ml_pipeline_start(pipe) < 0)
    return complain();
  for (i = 0; i < kFrames && !failed; ++i)
    if (make_data(info, (float)i, &data) < 0 ||
        ml_pipeline_src_input_data(src, data, ML_PIPELINE_BUF_POLICY_AUTO_FREE) < 0)
      failed = complain();
  if (!failed && ml_pipeline_src_input_data_eos(src) < 0) failed = complain();
  ml_pipeline_src_release_handle(src);
  return failed;
}

static int run_pipeline(const char* element, ml_tensors_info_h info) {
  char text[512];
  ml_pipeline_h pipe = NULL;
  Arrived arrived = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0};
  int failed;
  snprintf(text, sizeof text, "appsrc name=in ! %s ! tensor_sink name=out", element);
  if (ml_pipeline_construct(text, NULL, NULL, &pipe) < 0) return complain();
  failed = push_frames(pipe, info, &arrived) || wait_for_frames(pipe, &arrived);
  ml_pipeline_destroy(pipe);
  return failed;
}

int main(int argc, char** argv) {
  ml_tensors_info_h info = NULL;
  ml_custom_easy_filter_h filter = NULL;
  const ml_tensor_dimension dimension = {2};
  int failed = 1;
  if (argc != 2) {
    fprintf(stderr, "usage: %s ELEMENT\n", argv[0]);
    return 2;
  }
  if (ml_tensors_info_create(&info) < 0 || ml_tensors_info_set_count(info, 1) < 0 ||
      ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_FLOAT32) < 0 ||
      ml_tensors_info_set_tensor_dimension(info, 0, dimension) < 0 ||
      ml_pipeline_custom_easy_filter_register("twice", info, info, twice, NULL, &filter) < 0)
    return complain();
  failed = run_once(info) || run_pipeline(argv[1], info);
  ml_pipeline_custom_easy_filter_unregister(filter);
  ml_tensors_info_destroy(info);
  return failed;
}
