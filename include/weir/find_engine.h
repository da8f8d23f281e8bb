/* An extension of the host (weir_host's `extension`) for engines that delegate a model to another
 * engine, for example after translating it.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_FIND_ENGINE_H
#define WEIR_FIND_ENGINE_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_FIND_ENGINE "weir.find-engine/1"

typedef struct {
  uint32_t struct_size;
  /* Finds the engine with this name or alias. Its module is opened on first use and stays open.
   * Returns 0, or below 0 with the error filled: ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED with the
   * install command, MODULE_REFUSED. Any thread, but not during weir_module_entry. */
  int (*find)(const char* name, const weir_engine** out, weir_error*);
} weir_engine_finder;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_FIND_ENGINE_H */
