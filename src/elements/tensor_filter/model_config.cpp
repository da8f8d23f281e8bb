// Finds the engine, the files and the options for the settings; converts properties to isolation
// settings, and the counters of a worker process to stats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_config.hpp"

#include <utility>

#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/custom_options.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/isolate/isolated_engine.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_filter/filter_properties.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

std::vector<std::string> split_paths(const std::string& model) {
  std::vector<std::string> out;
  for (const auto part : split(model, ",")) {
    const auto path = strip(part);
    if (!path.empty()) out.emplace_back(path);
  }
  return out;
}

bool automatic(const std::string& framework) {
  return framework.empty() || equal_ignoring_case(framework, "auto") ||
         equal_ignoring_case(framework, "any");
}

// Properties that engines may request by name (core/infer/model/declared_options.hpp).
std::vector<std::pair<std::string, std::string>> declared(const FilterSettings& s) {
  const auto number = [](auto value) { return value ? std::to_string(value) : ""; };
  std::vector<std::pair<std::string, std::string>> out{
      {"input", s.input},
      {"inputtype", s.inputtype},
      {"inputname", s.inputname},
      {"inputlayout", s.inputlayout},
      {"output", s.output},
      {"outputtype", s.outputtype},
      {"outputname", s.outputname},
      {"outputlayout", s.outputlayout},
      {"custom", s.custom},
      {"accelerator", s.accelerator},
      {"latency", number(s.latency)},
      {"throughput", number(s.throughput)},
      {"suspend", number(s.suspend)},
      {"shared-tensor-filter-key", s.shared_tensor_filter_key.value_or("")},
      {"invoke-dynamic", s.invoke_dynamic ? "true" : ""},
      {"invoke-async", s.invoke_async ? "true" : ""},
      {"async-timeout", s.invoke_async ? number(s.async_timeout) : ""}};
  std::erase_if(out, [](const auto& option) { return option.second.empty(); });
  return out;
}

// Without a name that is similar, an engine for the model's file is better than one of no name.
Error with_automatic_engine(Error error, const std::vector<std::string>& paths) {
  const bool is_guessed = !error.difference.empty();
  if (error.code == Code::ENGINE_UNKNOWN && !is_guessed &&
      infer::ModuleLibrary::instance().choose_engine(paths))
    error.fix = "framework=auto";
  return error;
}

// A pipeline description that reproduces the processing of a frame. It includes the limits of the
// worker process, because a frame may make the model allocate without limit.
std::string repeated(const FilterSettings& s) {
  std::string out = "tensor_filter";
  each_flagged([&](const auto& p) {
    if (!p.flags.repeated || s.*p.field == FilterSettings().*p.field) return;
    out += std::string(" ") + p.name + "=";
    if constexpr (std::is_convertible_v<decltype(s.*p.field), std::string>)
      out += launch_value(s.*p.field);
    else if constexpr (std::is_arithmetic_v<std::decay_t<decltype(s.*p.field)>>)
      out += std::to_string(s.*p.field);
  });
  return out + " isolate=process on-crash=error";
}

// A weak reference: the element may be finalised first.
class WeakElement {
 public:
  explicit WeakElement(GstElement* element) { g_weak_ref_init(&ref_, element); }
  ~WeakElement() { g_weak_ref_clear(&ref_); }
  WeakElement(const WeakElement&) = delete;
  WeakElement& operator=(const WeakElement&) = delete;
  gst::Ref<GstElement> get() {
    return gst::Ref<GstElement>::adopt(static_cast<GstElement*>(g_weak_ref_get(&ref_)));
  }

 private:
  GWeakRef ref_;
};

// The context for isolate::isolated_engine(). `automatic`: the engine is chosen by the model files.
std::shared_ptr<isolate::Isolation> make_isolation(const FilterSettings& s, bool automatic,
                                                   std::shared_ptr<isolate::Monitor> monitor) {
  auto out = std::make_shared<isolate::Isolation>();
  if (!automatic) out->engine = s.framework;
  out->timeout = std::chrono::milliseconds(s.isolate_timeout);
  out->memory_mib = s.isolate_memory;
  out->on_crash = s.on_crash;
  out->crash_folder = s.crash_folder;
  out->repeat = repeated(s);
  out->monitor = std::move(monitor);
  return out;
}

}  // namespace

Result<infer::ModelConfig> make_model_config(const FilterSettings& s,
                                             const std::shared_ptr<isolate::Monitor>& monitor,
                                             std::optional<Error>* warning) {
  const auto paths = split_paths(s.model);
  const auto no_model = [] {
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no model is set",
                 .offered = "model=\"\"",
                 .needed = "the path of a model file; weir models list prints models to try",
                 .fix = "model=/path/to/model"};
  };
  if (paths.empty() && automatic(s.framework)) return no_model();
  auto& library = infer::ModuleLibrary::instance();
  const auto engine = monitor ? Result<const weir_engine*>(&isolate::isolated_engine())
                      : automatic(s.framework) ? library.engine_for_model(paths)
                                               : library.engine(s.framework);
  if (!engine) return with_automatic_engine(engine.error(), paths);
  if (paths.empty() && !((*engine)->flags & WEIR_ENGINE_NEEDS_NO_MODEL)) return no_model();
  infer::ModelConfig source;
  source.engine = *engine;
  source.options.paths = paths;
  source.options.options = infer::custom_options(s.custom);
  source.options.declared = declared(s);
  source.options.threads = s.threads;
  if (monitor) {
    auto isolation = make_isolation(s, automatic(s.framework), monitor);
    isolation->declared = source.options.declared;
    source.options.host_context = std::move(isolation);
  }
  const auto request = infer::parse_accelerator(s.accelerator, warning);
  const auto supported = infer::list_accelerators(**engine);
  source.options.accelerator = infer::choose_accelerator(request, supported);
  if (auto unavailable =
          infer::unavailable_hardware(request, supported, (*engine)->name, s.accelerator))
    *warning = std::move(unavailable);
  return source;
}

std::string framework_name(const FilterSettings& s) {
  const auto choice = automatic_engine(s);
  return choice ? choice->engine : s.framework;
}

std::optional<infer::EngineChoice> automatic_engine(const FilterSettings& s) {
  if (!automatic(s.framework)) return std::nullopt;
  const auto paths = split_paths(s.model);
  if (paths.empty()) return std::nullopt;
  const auto choice = infer::ModuleLibrary::instance().choose_engine(paths);
  return choice ? std::optional(*choice) : std::nullopt;
}

std::shared_ptr<isolate::Monitor> make_monitor(const FilterSettings& settings,
                                               GstElement* element) {
  if (settings.isolate != IsolateChoice::Process) return nullptr;
  auto monitor = std::make_shared<isolate::Monitor>();
  if (settings.on_crash != isolate::OnCrash::Error)
    monitor->listen([owner = std::make_shared<WeakElement>(element),
                     saves = !settings.crash_folder.empty(),
                     restarts = isolate::restarts(settings.on_crash)](Error error) {
      // What is set already is no advice.
      if (restarts && error.fix == isolate::kRestartAndSave)
        error.fix = saves ? "another model file, or another framework" : "crash-folder=/tmp";
      if (const auto there = owner->get()) gst::post_warning(there.get(), error);
    });
  return monitor;
}

void log_confinement(const isolate::Monitor& monitor, GstElement* element) {
  const auto [text, refused] = monitor.confinement();
  GST_CAT_INFO_OBJECT(gst::get_category(element), element, "worker process: %s",
                      printable_text(text).c_str());
  if (!refused.empty())
    GST_CAT_WARNING_OBJECT(gst::get_category(element), element,
                           "not restricted for the worker process: %s",
                           printable_text(refused).c_str());
}

void add_worker_stats(const isolate::Monitor& monitor, GstStructure* stats) {
  const auto c = monitor.counts();
  gst_structure_set(stats, "worker-ended", G_TYPE_UINT64, c.ended, "worker-timeouts", G_TYPE_UINT64,
                    c.timed_out, "worker-restarts", G_TYPE_UINT64, c.restarted,
                    "worker-not-started", G_TYPE_UINT64, c.not_started, "worker-frames-lost",
                    G_TYPE_UINT64, c.frames_lost, "worker-frames-saved", G_TYPE_UINT64,
                    c.frames_saved, "worker-bytes-copied", G_TYPE_UINT64, c.bytes_copied,
                    "worker-confinement", G_TYPE_STRING,
                    printable_text(monitor.confinement().text).c_str(), nullptr);
}

}  // namespace weir
