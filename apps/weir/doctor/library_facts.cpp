// Opens libmosquitto, and looks for the elements of a build that has it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/library_facts.hpp"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>

namespace weir::app {
namespace {

// Of the library's API; the command does not link it.
using VersionOf = int (*)(int* major, int* minor, int* revision);

void read_version(void* library, LibraryFact* out) {
  if (link_map* loaded = nullptr; dlinfo(library, RTLD_DI_LINKMAP, &loaded) == 0 && loaded)
    out->file = loaded->l_name;
  const auto version_of = reinterpret_cast<VersionOf>(dlsym(library, "mosquitto_lib_version"));
  if (!version_of) return;
  int major = 0, minor = 0, revision = 0;
  version_of(&major, &minor, &revision);
  out->version =
      std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(revision);
}

// Whether the plug-in for streams between devices is there, and was built without MQTT.
bool is_built_without_mqtt(const PluginFacts& plugins) {
  const auto has = [&](const char* name) {
    return std::any_of(plugins.elements.begin(), plugins.elements.end(), [&](const auto& element) {
      return element.plugin == "weiredge" && element.name == name;
    });
  };
  return has("edgesink") && !has("mqttsink");
}

}  // namespace

std::vector<LibraryFact> library_facts(const PluginFacts& plugins) {
  LibraryFact out{.name = "libmosquitto",
                  .state = "usable",
                  .version = "",
                  .file = "",
                  .needed_for = "mqttsink, mqttsrc, connect-type=HYBRID and connect-type=MQTT",
                  .install = ""};
  void* const library = dlopen("libmosquitto.so.1", RTLD_LAZY | RTLD_LOCAL);
  if (library) {
    read_version(library, &out);
    dlclose(library);
  } else {
    out.state = "not installed";
    out.install = "apt-get install libmosquitto1";
  }
  if (is_built_without_mqtt(plugins)) {
    out.state = "not in this build";
    out.install = "apt-get install libmosquitto-dev && make install";
  }
  return {std::move(out)};
}

}  // namespace weir::app
