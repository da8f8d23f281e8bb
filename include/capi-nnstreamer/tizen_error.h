/* The error numbers of Tizen that NNStreamer's application API uses on every system
 * (docs/compatibility/app-api.md 8.7). C99.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef TIZEN_ERROR_H
#define TIZEN_ERROR_H
#include <errno.h>

#ifndef ESTRPIPE
#define ESTRPIPE EPIPE
#endif

typedef enum {
  TIZEN_ERROR_NONE = 0,
  TIZEN_ERROR_IO_ERROR = -EIO,
  TIZEN_ERROR_TRY_AGAIN = -EAGAIN,
  TIZEN_ERROR_OUT_OF_MEMORY = -ENOMEM,
  TIZEN_ERROR_PERMISSION_DENIED = -EACCES,
  TIZEN_ERROR_INVALID_PARAMETER = -EINVAL,
  TIZEN_ERROR_STREAMS_PIPE = -ESTRPIPE,
  TIZEN_ERROR_PACKAGE_MANAGER = -0x01150000,
  TIZEN_ERROR_UNKNOWN = -0x40000000,
  TIZEN_ERROR_TIMED_OUT = TIZEN_ERROR_UNKNOWN + 1,
  TIZEN_ERROR_NOT_SUPPORTED = TIZEN_ERROR_UNKNOWN + 2
} tizen_error_e;

#endif /* TIZEN_ERROR_H */
