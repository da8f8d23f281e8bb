// edgesink: sends the buffers of a stream to other processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <memory>
#include <mutex>

#include "elements/edgesink/edgesink_settings.hpp"
#include "elements/edgesink/local_output.hpp"
#include "gstcpp/element/base_classes.hpp"

namespace weir {
namespace {

using Outcome = BufferOutput::Outcome;

class Edgesink : public gst::Element<Edgesink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirEdgeSink", "edgesink", "EdgeSink", "Sink/Edge",
                                          "Sends the buffers of a stream to other processes"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = EdgesinkSettings;
  static constexpr std::tuple kProperties{
      gst::Property{"host", &Settings::host, "The address to listen on"},
      gst::Property{"port", &Settings::port, "The port to listen on; 0 = a free one",
                    gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"dest-host", &Settings::dest_host, "The address of the broker"},
      gst::Property{"dest-port", &Settings::dest_port, "The port of the broker",
                    gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"connect-type", &Settings::connect_type, "How receivers find this element"},
      gst::Property{"topic", &Settings::topic, "The name of the stream at the broker"},
      gst::Property{"wait-connection", &Settings::wait_connection,
                    "Wait for a receiver before the first buffer"},
      gst::Property{"connection-timeout", &Settings::connection_timeout,
                    "Milliseconds that wait-connection waits; 0 = no limit"},
      gst::Property{"custom-lib", &Settings::custom_lib,
                    "Accepted for compatibility; connect-type=CUSTOM is not available"},
      gst::Property{"protocol", &Settings::protocol, "What receivers speak"},
      gst::Property{"path", &Settings::path,
                    "The file name of the stream, a Unix socket (protocol=local)"},
      gst::Property{"max-buffers", &Settings::max_buffers,
                    "Buffers that a receiver may have and not have released (protocol=local)",
                    gst::Changeable::InReady, 1u, 96u},
      gst::Property{"drop", &Settings::drop,
                    "A receiver that has max-buffers misses buffers; false = the stream waits for "
                    "it (protocol=local)"},
  };

  Status start() {
    const Settings s = settings();
    if (auto status = check_edge_types(s.protocol, s.connect_type, kInfo.factory_name); !status)
      return status;
    auto output = LocalOutput::open({.path = s.path,
                                     .most_held = s.max_buffers,
                                     .drop = s.drop,
                                     .most_readers = kMostReceivers,
                                     .refused = [this](const Error& error) { log(error); }});
    if (!output) return output.error();
    ledger_.reset();
    has_waited_ = !s.wait_connection;
    const std::lock_guard lock(output_mutex_);
    output_ = *std::move(output);
    return ok();
  }

  gboolean stop() {
    std::shared_ptr<BufferOutput> output;
    const std::lock_guard lock(output_mutex_);
    output.swap(output_);
    return TRUE;
  }

  Status set_caps(GstCaps* caps) { return output_->set_caps(caps); }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    for (;;) {
      auto outcome = wait_for_receiver();
      if (outcome && *outcome == Outcome::Sent) outcome = output_->publish(buffer, &ledger_);
      if (!outcome) {
        ledger_.dropped(DropReason::Error);
        gst::post_error(element(), outcome.error());
        return GST_FLOW_ERROR;
      }
      if (*outcome != Outcome::Interrupted) return count(*outcome);
      // PAUSED, a flush or the end.
      const GstFlowReturn flow = gst_base_sink_wait_preroll(self());
      if (flow == GST_FLOW_OK) continue;
      ledger_.dropped(DropReason::Flush);
      return flow;
    }
  }

  gboolean event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) output_->end();
    return parent_class()->event(self(), event);
  }

  gboolean propose_allocation(GstQuery* query) {
    if (const auto output = current()) output->propose_allocation(query);
    return TRUE;
  }

  gboolean unlock() {
    if (const auto output = current()) output->interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    if (const auto output = current()) output->resume();
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    if (const auto output = current()) output->add_stats(stats);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  static constexpr uint32_t kMostReceivers = 32;
  static constexpr uint64_t kLongestTimeout = 1'000'000'000'000;  // ms

  std::shared_ptr<BufferOutput> current() const {
    const std::lock_guard lock(output_mutex_);
    return output_;
  }

  void log(const Error& error) const {
    GST_CAT_WARNING_OBJECT(category(), element(), "%s", error.message().c_str());
  }

  // Sent = there is a receiver, or none is waited for.
  Result<Outcome> wait_for_receiver() {
    if (has_waited_) return Outcome::Sent;
    const uint64_t limit = settings().connection_timeout;
    isolate::Deadline deadline;
    if (limit > 0)
      deadline = isolate::deadline_in(
          std::chrono::milliseconds(static_cast<int64_t>(std::min(limit, kLongestTimeout))));
    has_waited_ = output_->wait_for_receiver(deadline);
    if (has_waited_) return Outcome::Sent;
    if (!isolate::is_over(deadline)) return Outcome::Interrupted;
    return Error{.code = Code::SERVER_UNREACHABLE,
                 .what = "no receiver connected within connection-timeout",
                 .offered = "connection-timeout=" + std::to_string(limit) + " ms",
                 .needed = "an edgesrc that connects in time",
                 .fix = "edgesink wait-connection=false"};
  }

  GstFlowReturn count(Outcome outcome) {
    if (outcome == Outcome::Sent)
      ledger_.consumed();
    else
      ledger_.dropped(DropReason::Policy);
    return GST_FLOW_OK;
  }

  mutable std::mutex output_mutex_;  // guards output_ while it changes
  std::shared_ptr<BufferOutput> output_;
  bool has_waited_ = false;  // streaming thread
};

}  // namespace

bool register_edgesink(GstPlugin* plugin) {
  return Edgesink::register_in(plugin);
}

}  // namespace weir
