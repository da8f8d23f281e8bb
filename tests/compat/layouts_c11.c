/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* The layouts, as a C compiler has them. */
#define CHECK(condition, text) _Static_assert(condition, text)
#include "layouts.h"

int main(void) {
  return 0;
}
