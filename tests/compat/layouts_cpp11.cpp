// The layouts, as a C++ compiler has them.
#define CHECK(condition, text) static_assert(condition, text)
#include "layouts.h"

int main() {
  return 0;
}
