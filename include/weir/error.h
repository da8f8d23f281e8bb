/* Errors for programs. A function that takes a weir_error** stores a new object there when it
 * fails; free it with weir_error_free. Pass NULL to get only the return value. In C++: result.hpp.
 *
 * A condition or converter of the application receives a weir_error* to fill through host->fail; it
 * must not free that one.
 *
 * Exported by libweir (pkg-config weir). Texts are UTF-8 and live as long as the object, which only
 * one thread at a time may use.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_ERROR_H
#define WEIR_ERROR_H
#include "weir/abi.h"

#ifndef WEIR_EXPORT
#define WEIR_EXPORT __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Creates the error that a callback of the application returns to Weir (pipeline.h). Copies the
 * texts; NULL is "". A code of 0 or below becomes WEIR_INTERNAL. NULL when out of memory. */
WEIR_EXPORT weir_error* weir_error_new(int code, const char* what, const char* offered,
                                       const char* needed, const char* difference, const char* fix);
/* Returns a weir_code (codes.h), explained in docs/errors/WEIR-<code>.md; 0 for NULL. */
WEIR_EXPORT int weir_error_code(const weir_error* error);
/* Returns the whole error, of which the functions below return the parts:
 * "WEIR-2001: what\n  offered: ...\n  needed: ...\n  first difference: ...\n  fix: ...". Texts are
 * never NULL, even for a NULL error; "" = not set. */
WEIR_EXPORT const char* weir_error_message(weir_error* error);
WEIR_EXPORT const char* weir_error_what(const weir_error* error);
WEIR_EXPORT const char* weir_error_offered(const weir_error* error);
WEIR_EXPORT const char* weir_error_needed(const weir_error* error);
WEIR_EXPORT const char* weir_error_difference(const weir_error* error);
/* Returns a line to paste or a command to run. */
WEIR_EXPORT const char* weir_error_fix(const weir_error* error);
WEIR_EXPORT void weir_error_free(weir_error* error); /* NULL: no effect */

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ERROR_H */
