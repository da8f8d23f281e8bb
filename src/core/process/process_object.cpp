// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/process/process_object.hpp"

#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "core/config/install_paths.hpp"

namespace weir::process {
namespace {

struct Objects {
  std::mutex mutex;  // guards all
  std::map<std::pair<std::string, size_t>, void*> all;
};

std::atomic<Lookup> source{local_object};

}  // namespace

void* local_object(const char* name, size_t size, Make make) {
  static auto& objects = *new Objects;
  std::lock_guard lock(objects.mutex);
  void*& object = objects.all[{std::string(name) + "/" + config::kVersion, size}];
  if (!object) object = make();
  return object;
}

void take_objects_from(Lookup lookup) noexcept {
  source = lookup;
}

Lookup lookup() noexcept {
  return source;
}

}  // namespace weir::process
