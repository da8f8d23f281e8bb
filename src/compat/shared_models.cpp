// Interpreters shared by several elements, by key (docs/compatibility/filter.md 4.6).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "compat/guard.hpp"
#include "nnstreamer_plugin_api_filter.h"

using namespace weir::compat;

namespace {

struct Shared {
  void* interpreter;
  std::set<void*> users;  // instances
};
struct Table {
  std::mutex mutex;  // guards models; never held during a callback
  std::map<std::string, Shared, std::less<>> models;
};
Table& table() {
  static auto& all = *new Table;  // never freed: threads may outlive static objects
  return all;
}

}  // namespace

void* nnstreamer_filter_shared_model_get(void* instance, const char* key) {
  if (!given(__func__, {instance, key})) return nullptr;
  return or_else<void*>(__func__, nullptr, [&]() -> void* {
    std::lock_guard lock(table().mutex);
    const auto found = table().models.find(key);
    if (found == table().models.end()) return nullptr;
    found->second.users.insert(instance);
    return found->second.interpreter;
  });
}

void* nnstreamer_filter_shared_model_insert_and_get(void* instance, const char* key,
                                                    void* interpreter) {
  if (!given(__func__, {instance, key, interpreter})) return nullptr;
  return or_else<void*>(__func__, nullptr, [&] {
    std::lock_guard lock(table().mutex);
    auto& shared = table().models.try_emplace(key, Shared{interpreter, {}}).first->second;
    shared.users.insert(instance);
    return shared.interpreter;
  });
}

int nnstreamer_filter_shared_model_remove(void* instance, const char* key,
                                          void (*free_callback)(void* interpreter)) {
  if (!given(__func__, {instance, key})) return FALSE;
  return or_else(__func__, FALSE, [&]() -> int {
    void* unused = nullptr;
    {
      std::lock_guard lock(table().mutex);
      const auto found = table().models.find(key);
      if (found == table().models.end() || found->second.users.erase(instance) == 0) return FALSE;
      if (found->second.users.empty()) {
        unused = found->second.interpreter;
        table().models.erase(found);
      }
    }
    if (unused && free_callback) free_callback(unused);
    return TRUE;
  });
}

void nnstreamer_filter_shared_model_replace(void* instance, const char* key, void* new_interpreter,
                                            void (*replace_callback)(void*, void*),
                                            void (*free_callback)(void*)) {
  if (!given(__func__, {instance, key, new_interpreter})) return;
  attempt(__func__, [&] {
    void* old = nullptr;
    std::vector<void*> others;
    {
      std::lock_guard lock(table().mutex);
      const auto found = table().models.find(key);
      if (found == table().models.end() || found->second.interpreter == new_interpreter) return;
      old = std::exchange(found->second.interpreter, new_interpreter);
      for (void* user : found->second.users)
        if (user != instance) others.push_back(user);
    }
    if (replace_callback)
      for (void* user : others) replace_callback(user, new_interpreter);
    if (free_callback) free_callback(old);
  });
}
