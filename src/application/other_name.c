/* An empty library that loads libcapi-nnstreamer.so, which has the functions.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "ml-api-common.h"

extern const char* (*const weir_needs)(void);
const char* (*const weir_needs)(void) = ml_error;
