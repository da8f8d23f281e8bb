// Checks the layouts with a C++ compiler.
// SPDX-License-Identifier: LGPL-2.1-or-later
#define CHECK(condition, text) static_assert(condition, text)
#include "layouts.h"

int main() {
  return 0;
}
