// SPDX-License-Identifier: LGPL-2.1-or-later
#include "environment_variable.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <vector>

namespace weir::engine {

void add_environment_variable(const char* assignment) {
  static std::mutex mutex;
  static auto& replaced =
      *new std::vector<std::vector<char*>>;  // never freed: readers may use them
  const std::lock_guard lock(mutex);
  const size_t name = std::strcspn(assignment, "=") + 1;
  char** const old = environ;
  size_t count = 0;
  for (; old && old[count]; ++count)
    if (std::strncmp(old[count], assignment, name) == 0) return;
  std::vector<char*> longer(old, old + count);
  longer.push_back(const_cast<char*>(assignment));
  longer.push_back(nullptr);
  replaced.push_back(std::move(longer));
  __atomic_store_n(&environ, replaced.back().data(), __ATOMIC_RELEASE);
}

}  // namespace weir::engine
