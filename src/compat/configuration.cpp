// Reads nnstreamer.ini, finds the framework of a model, and returns the interface's release.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>
#include <string>
#include <vector>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/config/ini.hpp"
#include "core/infer/module/load_configuration.hpp"
#include "core/infer/module/module_library.hpp"
#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"
#include "nnstreamer_version.h"

using namespace weir::compat;

namespace {

std::optional<weir::config::Setting> setting(const gchar* group, const gchar* key) {
  return weir::infer::nnstreamer_configuration().find(group, key);
}

}  // namespace

gchar* nnsconf_get_custom_value_string(const gchar* group, const gchar* key) {
  if (!given(__func__, {group, key})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&]() -> gchar* {
    const auto found = setting(group, key);
    return found ? text(found->value) : nullptr;
  });
}

gboolean nnsconf_get_custom_value_bool(const gchar* group, const gchar* key, gboolean def) {
  if (!given(__func__, {group, key})) return def;
  return or_else(__func__, def, [&] {
    const auto found = setting(group, key);
    return found ? gboolean{weir::config::truth(found->value, def)} : def;
  });
}

gchar* gst_tensor_filter_detect_framework(const gchar* const* model_files, const guint num,
                                          const gboolean load_conf) {
  if (!given(__func__, {model_files})) return nullptr;
  return or_else<gchar*>(__func__, nullptr, [&]() -> gchar* {
    std::vector<std::string> paths;
    for (guint i = 0; i < num; ++i) {
      if (!given("gst_tensor_filter_detect_framework", {model_files[i]})) return nullptr;
      paths.emplace_back(model_files[i]);
    }
    // As in NNStreamer, also where no engine reads folders.
    std::error_code ignored;
    if (!paths.empty() && std::filesystem::is_directory(paths[0], ignored)) return text("nnfw");
    const auto nnstreamer = weir::infer::nnstreamer_configuration();
    const auto engines = weir::infer::ModuleLibrary::instance().engine_names();
    const auto choice = weir::infer::choose_engine(paths, engines, weir::infer::configuration(),
                                                   load_conf ? &nnstreamer : nullptr);
    if (choice) return text(choice->engine);
    warn("gst_tensor_filter_detect_framework", choice.error());
    return nullptr;
  });
}

gint find_key_strv(const gchar** strv, const gchar* key) {
  if (!given(__func__, {strv, key})) return -1;
  for (gint i = 0; strv[i]; ++i)
    if (g_ascii_strcasecmp(strv[i], key) == 0) return i;
  return -1;
}

gchar* nnstreamer_version_string(void) {
  return g_strdup("NNStreamer " NNSTREAMER_VERSION);
}

void nnstreamer_version_fetch(guint* major, guint* minor, guint* micro) {
  if (major) *major = NNSTREAMER_VERSION_MAJOR;
  if (minor) *minor = NNSTREAMER_VERSION_MINOR;
  if (micro) *micro = NNSTREAMER_VERSION_MICRO;
}
