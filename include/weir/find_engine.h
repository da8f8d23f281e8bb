 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* An extension of the host (weir_host's `extension`): for an engine that has another engine run
 * its model, as when a model is translated. */
#ifndef WEIR_FIND_ENGINE_H
#define WEIR_FIND_ENGINE_H
#include "weir/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_FIND_ENGINE "weir.find-engine/1"

typedef struct {
  uint32_t struct_size;
  /* The engine with this name or alias; its module is opened on first use and stays. Below 0 with
   * the error filled when there is none: ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED with the command that
   * brings it, MODULE_REFUSED. Any thread; not from weir_module_entry. */
  int (*find)(const char* name, const weir_engine** out, weir_error*);
} weir_engine_finder;

#ifdef __cplusplus
}
#endif
#endif /* WEIR_FIND_ENGINE_H */
