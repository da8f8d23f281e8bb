// The elements of a bin, and those that are installed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Lists the elements of a bin and of the bins in it.
inline std::vector<Ref<GstElement>> elements_in(GstElement* bin) {
  std::vector<Ref<GstElement>> out;
  const Unique<GstIterator, gst_iterator_free> all(gst_bin_iterate_recurse(GST_BIN(bin)));
  const auto add = +[](const GValue* item, gpointer list) {
    static_cast<std::vector<Ref<GstElement>>*>(list)->push_back(
        Ref<GstElement>::share(GST_ELEMENT(g_value_get_object(item))));
  };
  while (gst_iterator_foreach(all.get(), add, &out) == GST_ITERATOR_RESYNC) {
    gst_iterator_resync(all.get());
    out.clear();
  }
  return out;
}

// Lists the names that gst-inspect-1.0 knows.
inline std::vector<std::string> installed_elements() {
  std::vector<std::string> out;
  GList* all = gst_registry_get_feature_list(gst_registry_get(), GST_TYPE_ELEMENT_FACTORY);
  for (GList* at = all; at; at = at->next)
    out.emplace_back(gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(at->data)));
  gst_plugin_feature_list_free(all);
  return out;
}

}  // namespace weir::gst
