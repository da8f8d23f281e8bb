// Writes Prometheus' text format 0.0.4.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "serve/figures_page.hpp"

#include <algorithm>
#include <map>
#include <string_view>
#include <vector>

#include "core/config/install_paths.hpp"

namespace weir::app {
namespace {

struct Metric {
  std::string type, help;
  std::vector<std::string> samples;
};

// Numbers of stats that may fall again.
bool is_gauge(std::string_view name) {
  static constexpr std::string_view kGauges[] = {
      "held",    "requests-in-flight", "workers",    "workers-busy",
      "waiting", "bytes-held",         "bytes-most", "weights-bytes"};
  return std::find(std::begin(kGauges), std::end(kGauges), name) != std::end(kGauges);
}

std::string escaped_label(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\' || c == '"') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string metric_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return !((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')); }, '_');
  return "weir_" + name;
}

// `labels`: without braces.
void add_figure(const std::string& name, const Json& value, std::string labels,
                std::map<std::string, Metric>* metrics) {
  constexpr std::string_view kDropped = "dropped-", kMicroseconds = "-us";
  constexpr double kMicrosecond = 1e-6;
  std::string metric;
  Json number = value;
  bool gauge = value.is_number_float() || value.is_boolean() || is_gauge(name);
  if (value.is_boolean()) number = value.get<bool>() ? 1 : 0;
  if (name.starts_with(kDropped)) {  // the sum, "dropped", is that of its reasons
    metric = metric_name("dropped");
    labels += ",reason=\"" + escaped_label(name.substr(kDropped.size())) + "\"";
  } else if (name.ends_with(kMicroseconds)) {
    metric = metric_name(name.substr(0, name.size() - kMicroseconds.size())) + "_seconds";
    number = value.get<double>() * kMicrosecond;
    gauge = true;
  } else {
    metric = metric_name(name);
  }
  if (!gauge) metric += "_total";
  Metric& out = (*metrics)[metric];
  out.type = gauge ? "gauge" : "counter";
  out.help = name.starts_with(kDropped) ? "Frames dropped, by reason"
                                        : "The figure " + name + " of the property stats";
  out.samples.push_back(metric + "{" + labels + "} " + number.dump());
}

}  // namespace

std::string figures_page(const Json& ledgers) {
  std::map<std::string, Metric> metrics;
  for (const Json& ledger : ledgers) {
    const std::string name = ledger["name"], element = ledger["element"];
    const std::string model = name.substr(0, name.rfind('-'));
    const std::string labels =
        "model=\"" + escaped_label(model) + "\",element=\"" + escaped_label(element) + "\"";
    for (const auto& [key, value] : ledger["stats"].items())
      if ((value.is_number() || value.is_boolean()) && key != "dropped")
        add_figure(key, value, labels, &metrics);
  }
  std::string out =
      "# HELP weir_build_info The version of Weir\n# TYPE weir_build_info gauge\n"
      "weir_build_info{version=\"" +
      std::string(config::kVersion) + "\"} 1\n";
  for (const auto& [name, metric] : metrics) {
    out += "# HELP " + name + " " + metric.help + "\n# TYPE " + name + " " + metric.type + "\n";
    for (const auto& sample : metric.samples) out += sample + "\n";
  }
  return out;
}

}  // namespace weir::app
