/* A counter that callbacks increase and tests wait for. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WAIT_TEST_SUPPORT_H
#define WAIT_TEST_SUPPORT_H
#include <pthread.h>
#include <time.h>

#include "check_test_support.h"

typedef struct {
  pthread_mutex_t mutex;
  pthread_cond_t changed;
  int count;
} Counter;

#define COUNTER \
  { PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0 }

static inline void raise_count(Counter* counter) {
  pthread_mutex_lock(&counter->mutex);
  ++counter->count;
  pthread_cond_broadcast(&counter->changed);
  pthread_mutex_unlock(&counter->mutex);
}

static inline int get_count(Counter* counter) {
  int count;
  pthread_mutex_lock(&counter->mutex);
  count = counter->count;
  pthread_mutex_unlock(&counter->mutex);
  return count;
}

/* Fails when the count is not reached within a minute. */
static inline void wait_for(Counter* counter, int count) {
  struct timespec end;
  int late = 0;
  clock_gettime(CLOCK_REALTIME, &end);
  end.tv_sec += 60;
  pthread_mutex_lock(&counter->mutex);
  while (counter->count < count && !late)
    late = pthread_cond_timedwait(&counter->changed, &counter->mutex, &end);
  pthread_mutex_unlock(&counter->mutex);
  CHECK(!late);
}
#endif
