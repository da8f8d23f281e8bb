// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/ledger_table.hpp"

#include <algorithm>

#include "gstcpp/element/ref.hpp"
#include "gstcpp/element/value_json.hpp"
#include "weir/join.hpp"
#include "weir_plugins.hpp"

namespace weir::app {
namespace {

Json read_stats(GstElement* element) {
  GstStructure* stats = nullptr;
  g_object_get(element, "stats", &stats, nullptr);
  if (!stats) return Json::object();
  Json out = gst::json_from_structure(stats);
  gst_structure_free(stats);
  return out;
}

// The element's factory name; "" if it is not Weir's or has no ledger.
std::string weir_element(GstElement* element) {
  GstElementFactory* factory = gst_element_get_factory(element);
  if (!factory) return "";
  const char* plugin = gst_plugin_feature_get_plugin_name(GST_PLUGIN_FEATURE(factory));
  GParamSpec* stats = g_object_class_find_property(G_OBJECT_GET_CLASS(element), "stats");
  if (!plugin || !is_weir_plugin(plugin) || !stats || stats->value_type != GST_TYPE_STRUCTURE)
    return "";
  return gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory));
}

std::string number(const Json& stats, const char* name) {
  return stats.contains(name) ? stats[name].dump() : "-";
}

std::string reasons(const Json& stats) {
  constexpr std::string_view kPrefix = "dropped-";
  std::vector<std::string> out;
  for (const auto& [name, value] : stats.items())
    if (name.starts_with(kPrefix) && value.is_number() && value != 0)
      out.push_back(name.substr(kPrefix.size()) + " " + value.dump());
  return join(out, ", ");
}

// Frames that were processed together with other elements: here, or in the next element.
std::string fusion(const Json& stats) {
  std::vector<std::string> out;
  for (const auto& [name, text] :
       {std::pair{"fused-frames", " fused"}, {"deferred-frames", " deferred to the next element"}})
    if (stats.value(name, uint64_t{0}) > 0) out.push_back(stats[name].dump() + text);
  return join(out, ", ");
}

}  // namespace

Json ledgers(GstElement* pipeline) {
  Json out = Json::array();
  // Iterates from sinks to sources; the list is reversed below.
  gst::Unique<GstIterator, gst_iterator_free> sorted(gst_bin_iterate_sorted(GST_BIN(pipeline)));
  gst_iterator_foreach(
      sorted.get(),
      [](const GValue* item, gpointer user) {
        auto* list = static_cast<Json*>(user);
        auto* element = GST_ELEMENT(g_value_get_object(item));
        if (GST_IS_BIN(element))
          for (const auto& inner : ledgers(element)) list->push_back(inner);
        const std::string factory = weir_element(element);
        if (factory.empty()) return;
        const gst::UniqueText name(gst_element_get_name(element));
        list->push_back(
            {{"name", name.get()}, {"element", factory}, {"stats", read_stats(element)}});
      },
      &out);
  std::reverse(out.begin(), out.end());
  return out;
}

std::string ledger_table(const Json& ledgers) {
  if (ledgers.empty()) return "";
  std::vector<std::vector<std::string>> rows{
      {"element", "received", "consumed", "held", "pushed", "dropped", "bytes copied", "why"}};
  std::vector<std::string> fusions{"in one pass"};
  for (const auto& ledger : ledgers) {
    const Json& stats = ledger["stats"];
    rows.push_back({ledger["name"].get<std::string>(), number(stats, "received"),
                    number(stats, "consumed"), number(stats, "held"), number(stats, "pushed"),
                    number(stats, "dropped"), number(stats, "bytes-copied"), reasons(stats)});
    fusions.push_back(fusion(stats));
  }
  const bool any =
      std::any_of(fusions.begin() + 1, fusions.end(), [](const auto& f) { return !f.empty(); });
  for (size_t i = 0; any && i < rows.size(); ++i) rows[i].push_back(fusions[i]);
  return table(rows, "  ");
}

std::vector<std::vector<std::string>> server_rows(const Json& ledgers) {
  constexpr double kMicro = 1000, kNano = 1e6;
  const auto ms = [](const Json& server, const char* name, double unit) {
    if (!server.contains(name)) return std::string("-");
    const gst::UniqueText text(g_strdup_printf("%.1f", server[name].get<double>() / unit));
    return std::string(text.get());
  };
  std::vector<std::vector<std::string>> rows{{"filter", "server", "answered", "late", "refused",
                                              "lost", "in flight", "circuit", "p50 ms", "p95 ms",
                                              "p99 ms", "queue ms", "compute ms", "bytes out",
                                              "bytes in", "clock ahead ms", "within ms"}};
  for (const auto& ledger : ledgers) {
    if (!ledger["stats"].contains("servers")) continue;
    for (const Json& server : ledger["stats"]["servers"])
      rows.push_back({ledger["name"].get<std::string>(), server["address"].get<std::string>(),
                      number(server, "answered"), number(server, "late"), number(server, "refused"),
                      number(server, "lost"), number(server, "in-flight"),
                      server["circuit"].get<std::string>(), ms(server, "p50-us", kMicro),
                      ms(server, "p95-us", kMicro), ms(server, "p99-us", kMicro),
                      ms(server, "queue-us", kMicro), ms(server, "compute-us", kMicro),
                      number(server, "bytes-sent"), number(server, "bytes-received"),
                      ms(server, "clock-offset-ns", kNano), ms(server, "clock-error-ns", kNano)});
  }
  if (rows.size() == 1) rows.clear();
  return rows;
}

std::string filter_table(const Json& ledgers) {
  constexpr double kMicroseconds = 1000;
  const auto milliseconds = [](const Json& stats, const char* name) {
    const gst::UniqueText text(g_strdup_printf("%.3f", stats.value(name, 0.0) / kMicroseconds));
    return std::string(text.get());
  };
  std::vector<std::vector<std::string>> rows{{"filter", "invokes", "mean ms", "p99 ms"}};
  for (const auto& ledger : ledgers) {
    const Json& stats = ledger["stats"];
    if (ledger["element"] == "tensor_filter" && stats.value("invokes", uint64_t{0}) > 0)
      rows.push_back({ledger["name"].get<std::string>(), number(stats, "invokes"),
                      milliseconds(stats, "average-us"), milliseconds(stats, "p99-us")});
  }
  return rows.size() == 1 ? "" : table(rows, "  ");
}

}  // namespace weir::app
