/* An extension of an engine (weir_engine's `extension`) that reports on each server that an open
 * model is on. `tensor_filter` shows them in `stats`.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_ENGINE_SERVERS_H
#define WEIR_ENGINE_SERVERS_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_ENGINE_SERVERS "weir.servers/1"

/* Whether a server gets requests. */
enum weir_circuit {
  WEIR_CIRCUIT_CLOSED = 0,    /* it does */
  WEIR_CIRCUIT_HALF_OPEN = 1, /* one, whose answer closes the circuit */
  WEIR_CIRCUIT_OPEN = 2       /* none, until a probe finds it ready */
};

/* FROZEN. -1: not known. */
typedef struct {
  const char* address; /* valid until the model is closed */
  int32_t circuit;     /* weir_circuit */
  uint32_t in_flight;
  /* Requests that were sent to this server, by how they ended there. A request that another server
   * answered in the end is one of both. */
  uint64_t answered, late, refused, lost;
  uint64_t bytes_sent, bytes_received;
  int64_t p50_us, p95_us, p99_us; /* of the last answers */
  int64_t queue_us, compute_us;   /* mean time of a request in the server, as it reports it */
  /* How far the server's clock is ahead, in nanoseconds, within clock_error_ns; known only if that
   * is not below 0. */
  int64_t clock_offset_ns, clock_error_ns;
} weir_server;

typedef struct {
  uint32_t struct_size;
  /* Writes up to `room` servers of an open model, in the order of its addresses. Returns how many
   * it has, or below 0. Any thread, also during an invoke. */
  int (*read)(weir_model*, weir_server* out, uint32_t room);
  /* The address of the server that answered the last invoke of a session; null while none has.
   * Valid until the model is closed. Called by the thread of that invoke, before the next. */
  const char* (*answered_by)(weir_session*);
} weir_engine_servers;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ENGINE_SERVERS_H */
