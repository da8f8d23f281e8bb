// From properties to isolation, and from its counts to stats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/isolated_filter.hpp"

#include <utility>

#include "core/text/pasted.hpp"
#include "gstcpp/error.hpp"
#include "gstcpp/ref.hpp"

namespace weir {
namespace {

std::string property(const char* name, const std::string& value) {
  return value.empty() ? "" : std::string(" ") + name + "=" + launch_value(value);
}

// The element that does the same to the same frame: what makes the model, and the limits of its
// process, without which a frame that eats memory would eat the machine's.
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

// An element that may be gone.
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
  GST_INFO_OBJECT(element, "worker process: %s", text.c_str());
  if (!refused.empty())
    GST_WARNING_OBJECT(element, "the kernel leaves to the worker process: %s", refused.c_str());
}

void add_worker_stats(const isolate::Monitor& monitor, GstStructure* stats) {
  const auto c = monitor.counts();
  gst_structure_set(
      stats, "worker-ended", G_TYPE_UINT64, c.ended, "worker-timeouts", G_TYPE_UINT64, c.timed_out,
      "worker-restarts", G_TYPE_UINT64, c.restarted, "worker-not-started", G_TYPE_UINT64,
      c.not_started, "worker-frames-lost", G_TYPE_UINT64, c.frames_lost, "worker-frames-saved",
      G_TYPE_UINT64, c.frames_saved, "worker-bytes-copied", G_TYPE_UINT64, c.bytes_copied,
      "worker-confinement", G_TYPE_STRING, monitor.confinement().text.c_str(), nullptr);
}

}  // namespace weir
