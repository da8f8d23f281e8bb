// Converts properties to isolation settings, and its counters to stats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/isolated_filter.hpp"

#include <utility>

#include "core/text/shell_quote.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

std::string property(const char* name, const std::string& value) {
  return value.empty() ? "" : std::string(" ") + name + "=" + launch_value(value);
}

// A pipeline description that reproduces the processing of a frame. It includes the limits of the
// worker process, because a frame may make the model allocate without limit.
std::string repeated(const FilterSettings& s) {
  std::string out = "tensor_filter";
  for (const auto& [name, value] : {std::pair{"framework", s.framework},
                                    {"model", s.model},
                                    {"custom", s.custom},
                                    {"accelerator", s.accelerator},
                                    {"input", s.input},
                                    {"inputtype", s.inputtype},
                                    {"inputname", s.inputname},
                                    {"output", s.output},
                                    {"outputtype", s.outputtype},
                                    {"outputname", s.outputname}})
    out += property(name, value);
  if (s.isolate_memory) out += property("isolate-memory", std::to_string(s.isolate_memory));
  if (s.isolate_timeout != FilterSettings().isolate_timeout)
    out += property("isolate-timeout", std::to_string(s.isolate_timeout));
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

}  // namespace

std::shared_ptr<isolate::Isolation> isolation_of(const FilterSettings& s, bool automatic,
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

std::shared_ptr<isolate::Monitor> make_monitor(const FilterSettings& settings,
                                               GstElement* element) {
  if (settings.isolate != IsolateChoice::Process) return nullptr;
  auto monitor = std::make_shared<isolate::Monitor>();
  if (settings.on_crash != isolate::OnCrash::Error)
    monitor->listen([owner = std::make_shared<WeakElement>(element)](const Error& error) {
      if (const auto there = owner->get()) gst::post_warning(there.get(), error);
    });
  return monitor;
}

void log_confinement(const isolate::Monitor& monitor, GstElement* element) {
  const auto [text, refused] = monitor.confinement();
  GST_CAT_INFO_OBJECT(gst::category_of(element), element, "worker process: %s",
                      printable_text(text).c_str());
  if (!refused.empty())
    GST_CAT_WARNING_OBJECT(gst::category_of(element), element,
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
