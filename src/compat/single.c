 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* libnnstreamer-single.so is a name: its functions are those of libnnstreamer.so, which it needs.
 */
#include "nnstreamer_util.h"

extern void (*const weir_needs)(const char*, ...);
void (*const weir_needs)(const char*, ...) = nns_logi;
