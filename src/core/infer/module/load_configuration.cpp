// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/load_configuration.hpp"

#include <mutex>
#include <set>
#include <string>

#include "core/infer/module/host.hpp"
#include "core/process/process_object.hpp"

namespace weir::infer {
namespace {

struct ReportedFaults {
  std::mutex mutex;  // guards messages
  std::set<std::string> messages;
};

template <class Configuration>
Configuration loaded() {
  static auto& reported = process::object<ReportedFaults>("reported-configuration-faults");
  auto now = Configuration::load();
  for (const auto& fault : now.faults()) {
    const std::string message = fault.message();
    std::unique_lock lock(reported.mutex);
    if (!reported.messages.insert(message).second) continue;
    lock.unlock();
    host().log(WEIR_LOG_WARNING, "configuration", message.c_str());
  }
  return now;
}

}  // namespace

config::Configuration configuration() {
  return loaded<config::Configuration>();
}

config::NnstreamerConfiguration nnstreamer_configuration() {
  return loaded<config::NnstreamerConfiguration>();
}

}  // namespace weir::infer
