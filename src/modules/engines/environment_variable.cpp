// Adds an environment variable by replacing `environ` as a whole.
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
  static auto& replaced = *new std::vector<char**>;  // never freed: readers may use them
  const std::lock_guard lock(mutex);
  const size_t name = std::strcspn(assignment, "=") + 1;
  char** const old = environ;
  size_t count = 0;
  for (; old && old[count]; ++count)
    if (std::strncmp(old[count], assignment, name) == 0) return;
  auto* const longer = static_cast<char**>(std::malloc((count + 2) * sizeof(char*)));
  if (!longer) throw std::bad_alloc();
  std::copy_n(old, count, longer);
  longer[count] = const_cast<char*>(assignment);
  longer[count + 1] = nullptr;
  replaced.push_back(longer);
  __atomic_store_n(&environ, longer, __ATOMIC_RELEASE);
}

}  // namespace weir::engine
