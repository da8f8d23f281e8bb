// weir-worker: the process in which tensor_filter isolate=process runs a model. tensor_filter
// starts it with a socket as descriptor 3; it is useless on its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "core/isolate/confinement.hpp"
#include "core/isolate/worker_server.hpp"
#include "core/process/process_object.hpp"
#include "library/process.h"

namespace {

constexpr int kSocket = 3;

// Ends this process together with the thread that started it; false if that has already ended.
bool end_with(pid_t parent) {
  return prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() == parent;
}

// The pipeline handles Ctrl-C and an orderly stop.
void leave_signals_to_the_pipeline() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) signal(number, SIG_IGN);
}

// A thread may pin itself to a CPU, but not another thread (core/isolate/system_call_rules.cpp).
// OpenMP aborts the process when it cannot pin the threads that it starts.
void leave_threads_unpinned() {
  for (const char* name : {"OMP_PROC_BIND", "OMP_PLACES", "GOMP_CPU_AFFINITY", "KMP_AFFINITY"})
    unsetenv(name);
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A crash of the engine must end this process by its signal, which the host reports. Leak detection
// is impossible where no process may be traced.
#define WEIR_SIGNALS "handle_segv=0:handle_sigbus=0:handle_sigill=0:handle_sigfpe=0"
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() {
  return WEIR_SIGNALS ":detect_leaks=0";
}
extern "C" __attribute__((visibility("default"))) const char* __tsan_default_options() {
  return WEIR_SIGNALS;
}
#endif

// Usage: weir-worker PARENT MEMORY_MIB
int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("weir-worker is started by tensor_filter isolate=process\n", stderr);
    return 2;
  }
  if (!end_with(static_cast<pid_t>(std::atol(argv[1])))) return 2;
  leave_signals_to_the_pipeline();
  leave_threads_unpinned();
  weir::process::take_objects_from(weir_process_object);  // before the first use of such an object
  try {
    const auto confinement = weir::isolate::confine(std::strtoull(argv[2], nullptr, 10));
    bool well = false;
    {
      weir::isolate::WorkerServer server{weir::io::Descriptor(kSocket)};
      well = server.serve(confinement);
    }
    _exit(well ? 0 : 2);  // skips exit handlers of modules, which may hang
  } catch (const std::exception& e) {
    std::fprintf(stderr, "weir-worker: %s\n", e.what());
    return 2;
  }
}
