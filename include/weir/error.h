 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* What went wrong, for programs: functions that take a weir_error** put a new object there when
 * they fail, for weir_error_free. NULL for the place: the return value is all. In C++: result.hpp.
 *
 * A condition or converter of the process gets a weir_error* that it fills through host->fail; it
 * must not free that one.
 *
 * Exported by libweir (pkg-config weir). Texts are UTF-8 and live as long as the object; one thread
 * at a time may use it. */
#ifndef WEIR_ERROR_H
#define WEIR_ERROR_H
#include "weir/abi.h"

#ifndef WEIR_EXPORT
#define WEIR_EXPORT __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* For functions of a program that Weir calls and that say what went wrong (pipeline.h). Texts are
 * copied, NULL is ""; a code of 0 or below is WEIR_INTERNAL. NULL when memory ran out. */
WEIR_EXPORT weir_error* weir_error_new(int code, const char* what, const char* offered,
                                       const char* needed, const char* difference, const char* fix);
/* Above 0: a weir_code (codes.h); docs/errors/WEIR-<code>.md explains it. 0 for NULL. */
WEIR_EXPORT int weir_error_code(const weir_error* error);
/* "WEIR-2001: what\n  offered: ...\n  needed: ...\n  first difference: ...\n  fix: ...": all that
 * is known. The texts are never NULL; "" = not known, and of a NULL error all are. */
WEIR_EXPORT const char* weir_error_message(weir_error* error);
WEIR_EXPORT const char* weir_error_what(const weir_error* error);
WEIR_EXPORT const char* weir_error_offered(const weir_error* error);
WEIR_EXPORT const char* weir_error_needed(const weir_error* error);
WEIR_EXPORT const char* weir_error_difference(const weir_error* error);
/* A line to paste or a command to run. */
WEIR_EXPORT const char* weir_error_fix(const weir_error* error);
WEIR_EXPORT void weir_error_free(weir_error* error); /* NULL: nothing */

#ifdef __cplusplus
}
#endif
#endif /* WEIR_ERROR_H */
