/* Interface between libweir and the plug-in of the same version; not installed and not public.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_LIBRARY_PROCESS_H
#define WEIR_LIBRARY_PROCESS_H
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Calls weir::process::local_object of the library. */
__attribute__((visibility("default"))) void* weir_process_object(const char* name, size_t size,
                                                                 void* (*make)(void));

#ifdef __cplusplus
}
#endif
#endif /* WEIR_LIBRARY_PROCESS_H */
