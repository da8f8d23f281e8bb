// Finds the filters, then asks their engines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/engine_versions.hpp"

#include <set>
#include <string>

#include "core/infer/module/module_library.hpp"
#include "doctor/engine_facts.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

bool is_isolated(GObject* filter) {
  GValue value = G_VALUE_INIT;
  g_object_get_property(filter, "isolate", &value);
  const gst::UniqueText text(gst_value_serialize(&value));
  g_value_unset(&value);
  return g_strcmp0(text.get(), "process") == 0;
}

void add_engine(const GValue* item, gpointer names) {
  auto* element = G_OBJECT(g_value_get_object(item));
  const GstElementFactory* factory = gst_element_get_factory(GST_ELEMENT(element));
  const bool is_filter = factory && g_strcmp0(GST_OBJECT_NAME(factory), "tensor_filter") == 0;
  if (!is_filter || is_isolated(element)) return;
  char* name = nullptr;
  g_object_get(element, "framework", &name, nullptr);
  const gst::UniqueText owned(name);
  if (name) static_cast<std::set<std::string>*>(names)->insert(name);
}

}  // namespace

Json engine_versions(GstElement* pipeline) {
  std::set<std::string> names;
  gst::Unique<GstIterator, gst_iterator_free> all(gst_bin_iterate_recurse(GST_BIN(pipeline)));
  while (gst_iterator_foreach(all.get(), add_engine, &names) == GST_ITERATOR_RESYNC)
    gst_iterator_resync(all.get());
  Json out = Json::object();
  for (const auto& name : names) {
    const auto engine = infer::ModuleLibrary::instance().engine(name);
    const std::string version = engine ? engine_version(**engine) : "";
    if (!version.empty()) out[name] = version;
  }
  return out;
}

}  // namespace weir::app
