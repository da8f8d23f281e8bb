// The objects of the process, for GStreamer's plug-in, which contains a second copy of core.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "process.h"

#include "core/process/process_object.hpp"

void* weir_process_object(const char* name, size_t size, void* (*make)(void)) {
  if (!name || !make) return nullptr;
  return weir::process::local_object(name, size, make);
}
