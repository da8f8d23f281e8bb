/* libnnstreamer-single.so: an empty library that loads libnnstreamer.so, which has the functions.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "nnstreamer_util.h"

extern void (*const weir_needs)(const char*, ...);
void (*const weir_needs)(const char*, ...) = nns_logi;
