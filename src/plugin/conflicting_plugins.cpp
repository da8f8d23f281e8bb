// Conflicting plug-ins: GStreamer keeps one factory per element name, the last registered one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "conflicting_plugins.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/config/configuration.hpp"
#include "core/config/ini.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::plugin {
namespace {

// All elements of NNStreamer 2.7, including those that Weir does not have yet.
constexpr std::string_view kNnstreamer[] = {"tensor_aggregator",
                                            "tensor_converter",
                                            "tensor_crop",
                                            "tensor_debug",
                                            "tensor_decoder",
                                            "tensor_demux",
                                            "tensor_filter",
                                            "tensor_if",
                                            "tensor_merge",
                                            "tensor_mux",
                                            "tensor_query_client",
                                            "tensor_query_serversink",
                                            "tensor_query_serversrc",
                                            "tensor_rate",
                                            "tensor_reposink",
                                            "tensor_reposrc",
                                            "tensor_sink",
                                            "tensor_sparse_dec",
                                            "tensor_sparse_enc",
                                            "tensor_split",
                                            "tensor_src_iio",
                                            "tensor_trainer",
                                            "tensor_transform",
                                            "join",
                                            "edgesink",
                                            "edgesrc",
                                            "mqttsink",
                                            "mqttsrc",
                                            "datareposink",
                                            "datareposrc",
                                            "tensor_sink_grpc",
                                            "tensor_src_grpc"};

// Registers what the decision depends on: environment variables, and weir.ini in its folders.
void depend_on(GstPlugin* plugin, const config::Configuration& configuration) {
  const gchar* variables[] = {"WEIR_PLUGIN_PREFER_NNSTREAMER", "WEIR_CONFIG", nullptr};
  gst_plugin_add_dependency(plugin, variables, nullptr, nullptr, GST_PLUGIN_DEPENDENCY_FLAG_NONE);
  for (const auto& file : configuration.files()) {
    const std::filesystem::path path(file.path);
    const std::string folder = path.parent_path(), name = path.filename();
    const gchar* folders[] = {folder.c_str(), nullptr};
    const gchar* names[] = {name.c_str(), nullptr};
    gst_plugin_add_dependency(plugin, nullptr, folders, names, GST_PLUGIN_DEPENDENCY_FLAG_NONE);
  }
}

}  // namespace

bool yields_to(GstPlugin* plugin) {
  const auto configuration = config::Configuration::load();
  depend_on(plugin, configuration);
  const auto setting = configuration.find("plugin", "prefer_nnstreamer");
  return setting && config::truth(setting->value, false);
}

bool is_only_of_weir(const char* element) noexcept {
  return std::find(std::begin(kNnstreamer), std::end(kNnstreamer), std::string_view(element)) ==
         std::end(kNnstreamer);
}

void warn_of_another(GstPlugin* plugin, const char* element) {
  auto feature =
      gst::Ref<GstPluginFeature>::adopt(gst_registry_lookup_feature(gst_registry_get(), element));
  // A type is set once its plug-in is loaded. While a plug-in loads, no other may be loaded.
  if (!feature || !GST_IS_ELEMENT_FACTORY(feature.get()) ||
      gst_element_factory_get_element_type(GST_ELEMENT_FACTORY(feature.get())) == 0)
    return;
  const auto owner = gst::Ref<GstPlugin>::adopt(gst_plugin_feature_get_plugin(feature.get()));
  if (!owner || owner.get() == plugin) return;
  GST_CAT_WARNING(gst::library_category(),
                  "%s is now registered by Weir instead of the plug-in %s (%s): weir doctor",
                  element, gst_plugin_get_name(owner.get()), gst_plugin_get_filename(owner.get()));
  // The registry frees the replaced factory, but classes of elements in use refer to it without a
  // reference: keep it until the process ends.
  static auto& in_use = *new std::vector<gst::Ref<GstPluginFeature>>;
  in_use.push_back(std::move(feature));
}

}  // namespace weir::plugin
