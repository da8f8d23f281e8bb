// `weir serve`: models for clients that speak the Open Inference Protocol.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "core/config/install_paths.hpp"
#include "core/process/listener_lease.hpp"
#include "core/text/shell_quote.hpp"
#include "machine/install_command.hpp"
#include "report.hpp"
#include "run/diagnostics.hpp"
#include "run/ledger_table.hpp"
#include "serve/metrics_server.hpp"
#include "serve/serve_run.hpp"
#include "serve/served_models.hpp"

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
void add_metric(const std::string& name, const Json& value, std::string labels,
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

// A figure of the address, which each source reports.
constexpr std::string_view kCallsRefused = "calls-refused";

// The calls that the server refused before it read for which model they are.
Metric make_refused_metric(const Json& ledgers) {
  uint64_t refused = 0;  // a source that was started again has the figure since then
  for (const Json& ledger : ledgers)
    refused = std::max(refused, ledger["stats"].value(kCallsRefused, uint64_t{0}));
  return {
      .type = "counter",
      .help = "Calls refused for all models: tokens, certificates, limits of connections",
      .samples = {metric_name(std::string(kCallsRefused)) + "_total " + std::to_string(refused)}};
}

// `ledgers`: as of ledgers(); elements are named MODEL-source, MODEL-filter and MODEL-sink. Each
// number of their stats is a metric with the labels model and element:
// weir_received_total{model="resnet", element="tensor_filter"} 3. Durations are in seconds.
std::string metrics_page(const Json& ledgers) {
  std::map<std::string, Metric> metrics;
  metrics[metric_name(std::string(kCallsRefused)) + "_total"] = make_refused_metric(ledgers);
  for (const Json& ledger : ledgers) {
    const std::string name = ledger["name"], element = ledger["element"];
    const std::string model = name.substr(0, name.rfind('-'));
    const std::string labels =
        "model=\"" + escaped_label(model) + "\",element=\"" + escaped_label(element) + "\"";
    for (const auto& [key, value] : ledger["stats"].items())
      if ((value.is_number() || value.is_boolean()) && key != "dropped" && key != kCallsRefused)
        add_metric(key, value, labels, &metrics);
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

Status check_elements() {
  const auto plugin = gst::Ref<GstPlugin>::adopt(gst_plugin_load_by_name("weirnet"));
  if (plugin) return ok();
  return Error{
      .code = Code::MODULE_REFUSED,
      .what = "the plug-in weirnet, which serves models, is not installed",
      .offered = "no plug-in weirnet",
      .needed = "a build of Weir with gRPC",
      .fix = std::string(install_command("apt-get install gstreamer1.0-weir-net",
                                         "apt-get install libgrpc++-dev && make install"))};
}

Result<std::vector<ServedPipeline>> make_pipelines(const std::vector<NamedModel>& models,
                                                   const ServeOptions& options,
                                                   const ListenAddress& address) {
  std::vector<ServedPipeline> out;
  for (const auto& model : models) {
    auto pipeline = serving_pipeline(model, out.size() + 1, options, address).make();
    if (!pipeline) return pipeline.error();
    auto played = PlayedPipeline::make(*std::move(pipeline));
    if (!played) return played.error();
    out.push_back({model, *std::move(played)});
  }
  return out;
}

// What clients connect to, without the model.
std::string address_text(const ServeOptions& options, const ListenAddress& address, unsigned port) {
  const std::string scheme = options.tls_cert.empty() ? "grpc" : "grpcs";
  if (!address.unix_path.empty()) return "grpc+unix:" + address.unix_path + ":";
  ListenAddress shown = address;
  if (address.host == "0.0.0.0" || address.host == "::") shown.host = g_get_host_name();
  shown.port = std::to_string(port);
  return scheme + "://" + shown.text();
}

// Clients of a model that is restarted are answered meanwhile.
std::shared_ptr<const void> keep_listening(ListenAddress address, unsigned port) {
  if (address.unix_path.empty()) address.port = std::to_string(port);
  const auto keep = process::lease_listener().load();
  return keep ? keep(address.text()) : nullptr;
}

// The port is a property of the element, and here a part of --listen.
std::vector<Diagnostic> with_option(std::vector<Diagnostic> errors, ListenAddress address) {
  address.port = "0";
  for (auto& diagnostic : errors)
    if (diagnostic.error.fix.starts_with("port=0"))
      diagnostic.error.fix = "--listen " + shell_word(address.text()) + ", which uses a free port";
  return errors;
}

void print_models(const ServeRun& run, const std::string& address) {
  std::vector<std::vector<std::string>> rows;
  for (size_t i = 0; i < run.size(); ++i) {
    const Json tensors = run.describe_tensors(i);
    const auto text = [&tensors](const char* name) { return tensors[name].get<std::string>(); };
    rows.push_back({run.model(i).name, address + "/" + run.model(i).name,
                    "input " + text("inputtype") + " " + text("input"),
                    "output " + text("outputtype") + " " + text("output")});
  }
  std::fputs(table(std::move(rows), "").c_str(), stdout);
}

Result<std::unique_ptr<MetricsServer>> open_metrics(const ServeOptions& options,
                                                    const ServeRun& run) {
  const auto address = ListenAddress::parse(options.metrics, "--metrics");
  if (!address) return address.error();
  auto server = MetricsServer::open(*address, [&run] { return metrics_page(run.statistics()); });
  if (server) {
    ListenAddress shown = *address;
    shown.port = std::to_string((*server)->port());
    std::printf("metrics  http://%s/metrics\n", shown.text().c_str());
  }
  return server;
}

// Each connection needs two, and the usual soft limit is 1024.
void allow_all_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

// Ends the process, whose model still holds its thread.
[[noreturn]] void abort_request(int status) {
  std::fputs("weir: a model did not end its request in time, which is aborted\n", stderr);
  std::fflush(stdout);  // only this one: a model may hold the lock of a file of its own
  std::_Exit(status == kExitGood ? kExitError : status);
}

}  // namespace

int serve(const ServeOptions& options) {
  allow_all_descriptors();
  const auto address = ListenAddress::parse(options.listen, "--listen");
  if (!address) return report(address.error(), false);
  if (auto status = check_options(options, *address); !status) return report(status.error(), false);
  const auto models = read_models(options.models);
  if (!models) return report(models.error(), false);
  if (options.dry_run) {
    for (size_t i = 0; i < models->size(); ++i)
      std::puts(serving_pipeline((*models)[i], i + 1, options, *address).pasted().c_str());
    return kExitGood;
  }
  if (auto status = check_elements(); !status) return report(status.error(), false);
  auto pipelines = make_pipelines(*models, options, *address);
  if (!pipelines) return report(pipelines.error(), false);
  ServeRun run(*std::move(pipelines));
  if (const auto errors = run.start(); !errors.empty()) {
    print_errors(with_option(errors, *address));
    return kExitError;
  }
  const auto kept = keep_listening(*address, run.port());
  print_models(run, address_text(options, *address, run.port()));
  std::unique_ptr<MetricsServer> metrics;
  if (!options.metrics.empty()) {
    auto opened = open_metrics(options, run);
    if (!opened) return report(opened.error(), false);
    metrics = *std::move(opened);
  }
  std::fflush(stdout);
  const int status = run.play();
  const std::string ledger = ledger_table(run.statistics());
  if (!ledger.empty()) std::printf("\nLedger\n%s", ledger.c_str());
  if (!run.stop()) abort_request(status);
  return status;
}

}  // namespace weir::app
