// Replaces the C library's ioctl in the test program, so that GStreamer's allocators call this one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/dma_buf_test_support.hpp"

extern "C" [[gnu::visibility("default")]] int ioctl(int file, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  return weir::testing_memory::SyncWatch::ioctl(file, request, argument);
}
