/* Reports GLib's locks to ThreadSanitizer: they are futexes in a library without instrumentation.
 * tools/tsan preloads this; in a program without ThreadSanitizer it has no effect.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <glib-object.h>
#include <gst/gst.h>

#define OPTIONAL __attribute__((weak))
OPTIONAL void __tsan_mutex_pre_lock(void* mutex, unsigned flags);
OPTIONAL void __tsan_mutex_post_lock(void* mutex, unsigned flags, int recursion);
OPTIONAL int __tsan_mutex_pre_unlock(void* mutex, unsigned flags);
OPTIONAL void __tsan_mutex_post_unlock(void* mutex, unsigned flags);
OPTIONAL void __tsan_acquire(void* address);
OPTIONAL void __tsan_release(void* address);

enum { kTryLock = 1 << 4, kTryLockFailed = 1 << 5, kReentrant = 1 << 1, kRead = 1 << 3 };

/* The function with this name in GLib, looked up once. */
#define REAL(name)                                                                            \
  ({                                                                                          \
    static __typeof__(&name) found;                                                           \
    if (!__atomic_load_n(&found, __ATOMIC_ACQUIRE))                                           \
      __atomic_store_n(&found, (__typeof__(&name))dlsym(RTLD_NEXT, #name), __ATOMIC_RELEASE); \
    __atomic_load_n(&found, __ATOMIC_ACQUIRE);                                                \
  })

/* Reported as try-locks, which have no order: GStreamer takes the locks of two pads and of their
 * elements in either order. */
static void before_lock(void* mutex, unsigned flags) {
  if (__tsan_mutex_pre_lock) __tsan_mutex_pre_lock(mutex, flags | kTryLock);
}
static void after_lock(void* mutex, unsigned flags) {
  if (__tsan_mutex_post_lock) __tsan_mutex_post_lock(mutex, flags | kTryLock, 1);
}
static void before_unlock(void* mutex, unsigned flags) {
  if (__tsan_mutex_pre_unlock) __tsan_mutex_pre_unlock(mutex, flags);
}
static void after_unlock(void* mutex, unsigned flags) {
  if (__tsan_mutex_post_unlock) __tsan_mutex_post_unlock(mutex, flags);
}
static void acquire(void* address) {
  if (__tsan_acquire) __tsan_acquire(address);
}
static void release(void* address) {
  if (__tsan_release) __tsan_release(address);
}

#define LOCK(function, type, flags) \
  void function(type* mutex) {      \
    before_lock(mutex, flags);      \
    REAL(function)(mutex);          \
    after_lock(mutex, flags);       \
  }
#define TRY_LOCK(function, type, flags)                                   \
  gboolean function(type* mutex) {                                        \
    before_lock(mutex, flags);                                            \
    const gboolean locked = REAL(function)(mutex);                        \
    after_lock(mutex, (flags) | (locked ? 0 : (unsigned)kTryLockFailed)); \
    return locked;                                                        \
  }
#define UNLOCK(function, type, flags) \
  void function(type* mutex) {        \
    before_unlock(mutex, flags);      \
    REAL(function)(mutex);            \
    after_unlock(mutex, flags);       \
  }

#undef g_mutex_lock
#undef g_mutex_trylock
#undef g_mutex_unlock
LOCK(g_mutex_lock, GMutex, 0)
TRY_LOCK(g_mutex_trylock, GMutex, 0)
UNLOCK(g_mutex_unlock, GMutex, 0)
LOCK(g_rec_mutex_lock, GRecMutex, kReentrant)
TRY_LOCK(g_rec_mutex_trylock, GRecMutex, kReentrant)
UNLOCK(g_rec_mutex_unlock, GRecMutex, kReentrant)
LOCK(g_rw_lock_writer_lock, GRWLock, 0)
TRY_LOCK(g_rw_lock_writer_trylock, GRWLock, 0)
UNLOCK(g_rw_lock_writer_unlock, GRWLock, 0)
LOCK(g_rw_lock_reader_lock, GRWLock, kRead)
TRY_LOCK(g_rw_lock_reader_trylock, GRWLock, kRead)
UNLOCK(g_rw_lock_reader_unlock, GRWLock, kRead)

/* GLib locks the mutex again with an internal call that does not reach these functions. */
void g_cond_wait(GCond* cond, GMutex* mutex) {
  before_unlock(mutex, 0);
  after_unlock(mutex, 0);
  REAL(g_cond_wait)(cond, mutex);
  before_lock(mutex, 0);
  after_lock(mutex, 0);
}
gboolean g_cond_wait_until(GCond* cond, GMutex* mutex, gint64 end_time) {
  before_unlock(mutex, 0);
  after_unlock(mutex, 0);
  const gboolean in_time = REAL(g_cond_wait_until)(cond, mutex, end_time);
  before_lock(mutex, 0);
  after_lock(mutex, 0);
  return in_time;
}

#undef g_once_init_enter
#undef g_once_init_leave
gboolean(g_once_init_enter)(volatile void* location) {
  const gboolean enter = REAL(g_once_init_enter)(location);
  acquire((void*)location);
  return enter;
}
void(g_once_init_leave)(volatile void* location, gsize result) {
  release((void*)location);
  REAL(g_once_init_leave)(location, result);
}
gpointer g_once_impl(GOnce* once, GThreadFunc function, gpointer argument) {
  const gpointer result = REAL(g_once_impl)(once, function, argument);
  acquire(once);
  return result;
}

#define PUSH(function)                               \
  void function(GAsyncQueue* queue, gpointer data) { \
    release(data);                                   \
    REAL(function)(queue, data);                     \
  }
#define POP(function)                            \
  gpointer function(GAsyncQueue* queue) {        \
    const gpointer data = REAL(function)(queue); \
    if (data) acquire(data);                     \
    return data;                                 \
  }
PUSH(g_async_queue_push)
PUSH(g_async_queue_push_unlocked)
PUSH(g_async_queue_push_front)
POP(g_async_queue_pop)
POP(g_async_queue_pop_unlocked)
POP(g_async_queue_try_pop)
POP(g_async_queue_try_pop_unlocked)
gpointer g_async_queue_timeout_pop(GAsyncQueue* queue, guint64 timeout) {
  const gpointer data = REAL(g_async_queue_timeout_pop)(queue, timeout);
  if (data) acquire(data);
  return data;
}

/* GLib's pools hand work to their threads with internal calls. */
struct call {
  GstElementCallAsyncFunc function;
  gpointer data;
  GDestroyNotify destroy;
};
static void run_call(GstElement* element, gpointer given) {
  acquire(given);
  const struct call* call = given;
  call->function(element, call->data);
}
static void free_call(gpointer given) {
  struct call* call = given;
  if (call->destroy) call->destroy(call->data);
  g_free(call);
}
void gst_element_call_async(GstElement* element, GstElementCallAsyncFunc function, gpointer data,
                            GDestroyNotify destroy) {
  struct call* call = g_new(struct call, 1);
  *call = (struct call){function, data, destroy};
  release(call);
  REAL(gst_element_call_async)(element, run_call, call, free_call);
}

/* The thread that drops the last reference sees what others did before they dropped theirs. */
void g_object_unref(gpointer object) {
  release(object);
  acquire(object);
  REAL(g_object_unref)(object);
}
void gst_mini_object_unref(GstMiniObject* object) {
  release(object);
  acquire(object);
  REAL(gst_mini_object_unref)(object);
}
