/* A module that ends its process when its entry point is called. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include <signal.h>
#include <stddef.h>

#include "weir/abi.h"

__attribute__((visibility("default"))) const weir_module* weir_module_entry(const weir_host* host) {
  (void)host;
  raise(SIGSEGV);
  return NULL;
}
