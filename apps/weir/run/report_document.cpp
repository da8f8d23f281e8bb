// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/report_document.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <set>

#include "core/config/install_paths.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/trace/verdict.hpp"
#include "doctor/engine_info.hpp"
#include "doctor/machine_info.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"
#include "run/element_properties.hpp"
#include "run/secrets.hpp"

namespace weir::app {
namespace {

bool is_isolated(GObject* filter) {
  GValue value = G_VALUE_INIT;
  g_object_get_property(filter, "isolate", &value);
  const gst::UniqueText text(gst_value_serialize(&value));
  g_value_unset(&value);
  return g_strcmp0(text.get(), "process") == 0;
}

// {"onnxruntime": "1.20.1"}: each engine of a tensor_filter in the pipeline, which has opened its
// models, with the version of the engine's library. Without engines that have no version, and
// without those of isolate=process, which this process does not load.
Json engine_versions(GstElement* pipeline) {
  std::set<std::string> names;
  for (const auto& element : gst::elements_in(pipeline)) {
    auto* filter = G_OBJECT(element.get());
    if (gst::get_factory_name(element.get()) != "tensor_filter" || is_isolated(filter)) continue;
    char* name = nullptr;
    g_object_get(filter, "framework", &name, nullptr);
    const gst::UniqueText owned(name);
    if (name) names.insert(name);
  }
  Json out = Json::object();
  for (const auto& name : names) {
    const auto engine = infer::ModuleLibrary::instance().engine(name);
    const std::string version = engine ? engine_version(**engine) : "";
    if (!version.empty()) out[name] = version;
  }
  return out;
}

Json host() {
  const MachineInfo machine = get_machine_info();
  utsname system{};
  const bool is_known = uname(&system) == 0;
  const auto now = gst::Unique<GDateTime, g_date_time_unref>(g_date_time_new_now_utc());
  const gst::UniqueText time(now ? g_date_time_format(now.get(), "%Y-%m-%dT%H:%M:%SZ") : nullptr);
  return {
      {"name", is_known ? system.nodename : ""},
      {"system",
       is_known ? std::string(system.sysname) + " " + system.release + " " + system.machine : ""},
      {"processor", machine.processor},
      {"cores", machine.cores},
      {"gpus", machine.gpus},
      {"memory_bytes", machine.memory_bytes},
      {"time", time ? time.get() : ""}};
}

Json versions(GstElement* pipeline) {
  guint major = 0, minor = 0, micro = 0, nano = 0;
  gst_version(&major, &minor, &micro, &nano);
  return {{"weir", config::kVersion},
          {"gstreamer",
           std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(micro)},
          {"engines", engine_versions(pipeline)}};
}

std::string path_in(const Json& elements, const Json& element) {
  const std::string name = element["name"];
  const Json& parent = element["parent"];
  return parent.is_number() ? path_in(elements, elements[parent.get<size_t>()]) + "/" + name : name;
}

const Json* find_ledger(const Json& outcome, const Json& element) {
  for (const Json& ledger : outcome["ledger"])
    if (ledger["name"] == element["name"] && ledger["element"] == element["factory"])
      return &ledger["stats"];
  return nullptr;
}

struct Times {
  double work = 0, waiting = 0;  // seconds
};

// A thread of the stream may wait for a model that runs in threads of its own: that is work, for
// several workers the mean of theirs.
Times get_times(const Json& element, const Json* stats) {
  const auto sum = [&element](const char* in_pushes, const char* between) {
    return element[in_pushes].get<double>() + element[between].get<double>();
  };
  const Times traced{sum("work", "thread_work"), sum("waiting", "thread_waiting")};
  if (!stats || !stats->contains("invokes") || !stats->contains("average-us")) return traced;
  const double invokes = (*stats)["invokes"], mean_us = (*stats)["average-us"];
  const double workers = std::max(stats->value("workers", 1.0), 1.0);
  const double model = invokes * mean_us * 1e-6;
  if (workers > 1) return {model / workers, 0};
  const double work = std::max(traced.work, model);
  return {work, std::max(traced.work + traced.waiting - work, 0.0)};
}

trace::Waits waits_from(const Json& element) {
  const std::string name = element["waits"];
  return name == "clock"    ? trace::Waits::Clock
         : name == "device" ? trace::Waits::Device
                            : trace::Waits::Never;
}

// Elements whose errors are the cause come first: Weir's name what is wrong, and others fail of it.
std::vector<trace::Failure> failures(const Json& outcome) {
  std::vector<trace::Failure> out, others;
  for (const Json& error : outcome["errors"])
    (error.contains("id") ? out : others).push_back({error["element"], error["what"]});
  out.insert(out.end(), others.begin(), others.end());
  return out;
}

// Itself, or a bin that it is in; the pipeline does not count.
bool has_failed(const Json& outcome, const std::string& path) {
  return std::any_of(
      outcome["errors"].begin(), outcome["errors"].end(), [&path](const Json& error) {
        const std::string failed = error.value("path", "");
        return failed == path ||
               (failed.find('/') != std::string::npos && path.starts_with(failed + "/"));
      });
}

// Names and messages of elements can have addresses in them, too.
void hide_secrets(Json* value) {
  if (value->is_string())
    *value = without_secrets(value->get_ref<const std::string&>());
  else if (value->is_structured())
    for (Json& member : *value) hide_secrets(&member);
}

Json verdict(const std::vector<trace::Load>& loads, const Json& outcome) {
  const trace::Verdict it = trace::judge(loads, failures(outcome));
  return {{"kind", to_string(it.kind)},
          {"element", it.element},
          {"share", it.share},
          {"text", it.text}};
}

}  // namespace

Json report_document(const Json& outcome, Json trace, const std::string& text,
                     GstElement* pipeline) {
  const Json properties = changed_properties(pipeline);
  const double seconds = trace["flow_seconds"];
  const auto share = [seconds](double time) { return seconds > 0 ? time / seconds : 0; };
  std::vector<trace::Load> loads;
  for (Json& element : trace["elements"]) {
    const std::string path = path_in(trace["elements"], element);
    const Json* stats = find_ledger(outcome, element);
    element["path"] = path;
    const Times times = get_times(element, stats);
    element["share"] = share(times.work);
    element["waiting_share"] = share(times.waiting);
    element["failed"] = has_failed(outcome, path);
    element["properties"] = properties.value(path, Json::object());
    if (stats) element["stats"] = *stats;
    if (element["bin"] || element["parent"].is_null()) continue;
    loads.push_back({element["name"], element["share"], element["waiting_share"],
                     waits_from(element), element["source"], element["sink"],
                     element["in"]["frames"], element["out"]["frames"]});
  }
  Json out{{"verdict", verdict(loads, outcome)}, {"pipeline", text},   {"host", host()},
           {"versions", versions(pipeline)},     {"outcome", outcome}, {"trace", std::move(trace)}};
  hide_secrets(&out);
  return out;
}

}  // namespace weir::app
