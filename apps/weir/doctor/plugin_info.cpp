// SPDX-License-Identifier: LGPL-2.1-or-later
#include "doctor/plugin_info.hpp"

#include <gst/gst.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "core/config/configuration.hpp"
#include "core/config/ini.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"
#include "machine/environment.hpp"
#include "weir_plugins.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;
using gst::Ref;

constexpr const char* kPluginName = "weir";
constexpr const char* kPluginFile = "libgstweir.so";

void add_folders(const char* list, std::vector<std::string>* out) {
  const std::string text = or_empty(list);
  for (const auto part : split(text, ":"))
    if (!part.empty()) out->emplace_back(part);
}

// GST_PLUGIN_PATH first, then the system's folders, in the order of gst_init.
std::vector<std::string> search_folders() {
  const auto variable = [](const char* versioned, const char* plain) {
    const char* value = environment_variable(versioned);
    return value ? value : environment_variable(plain);
  };
  std::vector<std::string> out;
  add_folders(variable("GST_PLUGIN_PATH_1_0", "GST_PLUGIN_PATH"), &out);
  const char* system = variable("GST_PLUGIN_SYSTEM_PATH_1_0", "GST_PLUGIN_SYSTEM_PATH");
  if (system) {
    add_folders(system, &out);
  } else {
    out.push_back((fs::path(g_get_user_data_dir()) / "gstreamer-1.0" / "plugins").string());
    out.emplace_back(GST_PLUGIN_DIR);
  }
  return out;
}

// Name prefixes of tensor elements, whichever plug-in provides them.
bool named_like_ours(const std::string& name) {
  return name.starts_with("tensor_") || name == "mqttsrc" || name == "mqttsink" || name == "join" ||
         name == "edgesrc" || name == "edgesink" || name.starts_with("datarepo");
}

std::vector<ElementInfo> list_elements(GstRegistry* registry) {
  std::vector<ElementInfo> out;
  GList* list = gst_registry_get_feature_list(registry, GST_TYPE_ELEMENT_FACTORY);
  for (GList* item = list; item; item = item->next) {
    auto* feature = GST_PLUGIN_FEATURE(item->data);
    const auto plugin = Ref<GstPlugin>::adopt(gst_plugin_feature_get_plugin(feature));
    ElementInfo fact;
    fact.name = or_empty(gst_plugin_feature_get_name(feature));
    fact.plugin = or_empty(gst_plugin_feature_get_plugin_name(feature));
    if (plugin) fact.file = or_empty(gst_plugin_get_filename(plugin.get()));
    fact.rank = gst_plugin_feature_get_rank(feature);
    if (is_weir_plugin(fact.plugin) || named_like_ours(fact.name)) out.push_back(std::move(fact));
  }
  gst_plugin_feature_list_free(list);
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return out;
}

void inspect_plugin(GstRegistry* registry, PluginInfo* facts) {
  const auto plugin = Ref<GstPlugin>::adopt(gst_registry_find_plugin(registry, kPluginName));
  if (plugin) {
    facts->found = true;
    facts->file = or_empty(gst_plugin_get_filename(plugin.get()));
    facts->version = or_empty(gst_plugin_get_version(plugin.get()));
  }
  std::string file = facts->file;
  for (const auto& folder : facts->searched) {
    std::error_code ignored;
    const std::string path = (fs::path(folder) / kPluginFile).string();
    if (file.empty() && fs::is_regular_file(path, ignored)) file = path;
  }
  if (file.empty()) return;
  GError* error = nullptr;
  const auto loaded = Ref<GstPlugin>::adopt(gst_plugin_load_file(file.c_str(), &error));
  if (!loaded) facts->load_error = error ? error->message : "the reason is unknown";
  if (!loaded) facts->found = false;
  if (!loaded) facts->file = file;
  g_clear_error(&error);
}

void find_duplicates(PluginInfo* facts) {
  for (const auto& folder : facts->searched) {
    std::error_code ignored;
    const fs::path path = fs::path(folder) / kPluginFile;
    if (!fs::is_regular_file(path, ignored) || facts->file.empty() ||
        fs::equivalent(path, facts->file, ignored))
      continue;
    facts->conflicts.push_back({kPluginName, path.string(),
                                "another copy of Weir's plug-in; GStreamer uses the first",
                                "remove one of the two (make uninstall)"});
  }
}

// GStreamer keeps one element per name, so an element taken over by another plug-in is recognised
// by its owner; a plug-in whose elements were replaced only by the plug-in's name.
void find_foreign_elements(GstRegistry* registry, PluginInfo* facts) {
  const auto add = [facts](const std::string& plugin, const std::string& file,
                           const std::string& element) {
    for (const auto& known : facts->conflicts)
      if (known.plugin == plugin) return;
    facts->conflicts.push_back(
        {plugin, file,
         element.empty() ? "it has elements with the same names as Weir"
                         : "GStreamer uses " + element + " from that plug-in, not from Weir",
         facts->yields_to.empty()
             ? "remove the package that provides the plug-in " + plugin +
                   ", or set GST_PLUGIN_PATH to folders without it, or, for its "
                   "elements, WEIR_PLUGIN_PREFER_NNSTREAMER=true"
             : "nothing if you want this; otherwise correct " + facts->yields_to +
                   ", which sets prefer_nnstreamer"});
  };
  for (const auto& element : facts->elements)
    if (!is_weir_plugin(element.plugin)) add(element.plugin, element.file, element.name);
  const auto other = Ref<GstPlugin>::adopt(gst_registry_find_plugin(registry, "nnstreamer"));
  if (other) add("nnstreamer", or_empty(gst_plugin_get_filename(other.get())), "");
}

void add_versions(GstRegistry* registry, PluginInfo* facts) {
  for (auto& conflict : facts->conflicts) {
    const auto found =
        Ref<GstPlugin>::adopt(gst_registry_find_plugin(registry, conflict.plugin.c_str()));
    if (found && conflict.file == or_empty(gst_plugin_get_filename(found.get())))
      conflict.version = or_empty(gst_plugin_get_version(found.get()));
  }
}

// GStreamer does not scan a plug-in again after Weir releases the names that it had taken over.
void find_missing_elements(PluginInfo* facts) {
  const auto is_filter = [](const ElementInfo& element) { return element.name == "tensor_filter"; };
  if (facts->yields_to.empty() ||
      std::any_of(facts->elements.begin(), facts->elements.end(), is_filter))
    return;
  const char* named = environment_variable("GST_REGISTRY");
  facts->conflicts.push_back(
      {kPluginName, facts->file,
       "Weir yields to NNStreamer (" + facts->yields_to +
           "), but GStreamer's registry has no tensor_filter: NNStreamer's plug-in is not "
           "installed, "
           "or the registry dropped it when Weir registered elements with the same names",
       std::string("rm ") + (named ? named : "~/.cache/gstreamer-1.0/registry.*")});
}

}  // namespace

PluginInfo get_plugin_info() {
  PluginInfo facts;
  const gst::UniqueText version(gst_version_string());
  facts.gstreamer = version.get();
  facts.searched = search_folders();
  GstRegistry* registry = gst_registry_get();
  const auto setting = config::Configuration::load().find("plugin", "prefer_nnstreamer");
  if (setting && config::truth(setting->value, false)) facts.yields_to = setting->origin;
  // Read before loading, which registers Weir's elements again and so changes the owners.
  facts.elements = list_elements(registry);
  inspect_plugin(registry, &facts);
  find_duplicates(&facts);
  find_foreign_elements(registry, &facts);
  add_versions(registry, &facts);
  find_missing_elements(&facts);
  return facts;
}

}  // namespace weir::app
