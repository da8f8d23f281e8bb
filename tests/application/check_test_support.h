/* Checks for tests in C99: each is counted; a failed check is reported and the test continues. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef CHECK_TEST_SUPPORT_H
#define CHECK_TEST_SUPPORT_H
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ml-api-common.h"

static int failed_checks;

/* Flushes, so that reports survive a crash in a later line. */
#define REPORT(...) (printf(__VA_ARGS__), fflush(stdout))

static __thread char kept_error[4096]; /* each thread has its own last error */

/* The text of the last failure. ml_error() returns it only once. */
static inline const char* last_error(void) {
  const char* text = ml_error();
  if (text) snprintf(kept_error, sizeof kept_error, "%s", text);
  return kept_error;
}

static inline void forget_last_error(void) {
  (void)ml_error();
  kept_error[0] = '\0';
}

#define CHECK(condition)                                               \
  do {                                                                 \
    if (!(condition)) {                                                \
      REPORT("%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      REPORT("  last error: %s\n", last_error());                      \
      ++failed_checks;                                                 \
    }                                                                  \
  } while (0)

/* The call returns `number`, and its ml_error() contains these words, at least one. */
#define CHECK_REFUSED(call, number, words)                                                    \
  do {                                                                                        \
    int result_;                                                                              \
    forget_last_error();                                                                      \
    result_ = (call);                                                                         \
    if (result_ != (number) || !*(words) || !strstr(last_error(), words)) {                   \
      REPORT("%s:%d: %s gave %d with: %s\n  wanted %d with: %s\n", __FILE__, __LINE__, #call, \
             result_, last_error(), (int)(number), words);                                    \
      ++failed_checks;                                                                        \
    }                                                                                         \
  } while (0)

#define OK(call) CHECK((call) == ML_ERROR_NONE)

/* An info with one tensor; free it with ml_tensors_info_destroy. */
static inline ml_tensors_info_h make_info(ml_tensor_type_e type, unsigned int first,
                                          unsigned int second) {
  ml_tensors_info_h info = NULL;
  ml_tensor_dimension dimension = {0};
  dimension[0] = first;
  dimension[1] = second;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_set_count(info, 1));
  OK(ml_tensors_info_set_tensor_type(info, 0, type));
  OK(ml_tensors_info_set_tensor_dimension(info, 0, dimension));
  return info;
}

/* One tensor, float32 2: `first` and its negative; free it with ml_tensors_data_destroy. */
static inline ml_tensors_data_h two_floats(float first) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 0);
  ml_tensors_data_h data = NULL;
  const float values[2] = {first, -first};
  OK(ml_tensors_data_create(info, &data));
  OK(ml_tensors_data_set_tensor_data(data, 0, values, sizeof values));
  OK(ml_tensors_info_destroy(info));
  return data;
}

/* The values of tensor `index`, or NULL. */
static inline const float* floats(ml_tensors_data_h data, unsigned int index, size_t count) {
  void* memory = NULL;
  size_t size = 0;
  OK(ml_tensors_data_get_tensor_data(data, index, &memory, &size));
  CHECK(size == count * sizeof(float));
  return size == count * sizeof(float) ? (const float*)memory : NULL;
}

static inline int result_of_checks(void) {
  if (failed_checks) printf("%d checks failed\n", failed_checks);
  return failed_checks > 0;
}
#endif
