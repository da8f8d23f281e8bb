// edgesink: sends the buffers of a stream to other processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "edge/addresses.hpp"
#include "edge/broker_login.hpp"
#include "edge/edge_broker.hpp"
#include "edge/edge_connect_type.hpp"
#include "edge/edgesink/mqtt_output.hpp"
#include "edge/edgesink/tcp_output.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/playing_gate.hpp"
#include "transport/local/publisher.hpp"

namespace weir {
namespace {

using OutputOutcome = BufferOutput::Outcome;

constexpr uint32_t kMaxBuffers = 96;  // of max-buffers

wire::MqttForm to_mqtt_form(WireVersion version) {
  switch (version) {
    case WireVersion::Bytes160:
      return wire::MqttForm::Bytes144;
    case WireVersion::Bytes168:
      return wire::MqttForm::Bytes160;
    case WireVersion::Bytes2088:
      break;
  }
  return wire::MqttForm::Bytes2080;
}

Error fallen_behind(const edge::Outage& outage, uint32_t max_buffers) {
  const bool is_full = outage.queued >= max_buffers;
  const bool can_grow = is_full && max_buffers < kMaxBuffers;
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a receiver is slower than the stream, and misses buffers",
               .offered = outage.address + ": " + std::to_string(outage.queued) +
                          (is_full ? " buffers wait for it (max-buffers), "
                                   : " buffers wait for it (as many as 256 MiB have room for), ") +
                          std::to_string(outage.missed) + " dropped so far",
               .needed = std::string("a receiver that reads as fast as the stream") +
                         (can_grow ? ", or room for more buffers while it is slow" : "") +
                         "; protocol=local waits for receivers on this machine",
               .fix = can_grow ? "edgesink max-buffers=" + std::to_string(kMaxBuffers) : ""};
}

struct EdgesinkSettings : BrokerLogin {
  EdgeProtocol protocol = EdgeProtocol::Edge;
  EdgeConnectType connect_type = EdgeConnectType::Tcp;
  std::string host = "localhost", dest_host = "localhost";
  uint32_t port = 3000, dest_port = 3000;
  std::optional<std::string> topic, custom_lib;
  bool wait_connection = false;
  uint64_t connection_timeout = 0;  // ms; 0 = no limit
  std::string path;
  uint32_t max_buffers = 16;
  bool drop = false;
  WireVersion wire_version = WireVersion::Bytes2088;
  bool insecure = false;
  std::string allow;
};

class Edgesink : public gst::Element<Edgesink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirEdgeSink", "edgesink", "EdgeSink", "Sink/Edge",
                                          "Sends the buffers of a stream to other processes"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = EdgesinkSettings;
  static constexpr auto kProperties = std::tuple_cat(
      kBrokerLoginProperties,
      std::tuple{
          gst::Property{"host", &Settings::host, "Address to listen on"},
          gst::Property{"port", &Settings::port,
                        "Port to listen on; 0 = a free port, which stats contains as port",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"dest-host", &Settings::dest_host, "Address of the MQTT broker"},
          gst::Property{"dest-port", &Settings::dest_port, "Port of the MQTT broker",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"connect-type", &Settings::connect_type, "How receivers find this element"},
          gst::Property{"topic", &Settings::topic, "Name of the stream at the MQTT broker"},
          gst::Property{"wait-connection", &Settings::wait_connection,
                        "Wait for a receiver before the first buffer; false = drop buffers without "
                        "a receiver"},
          gst::Property{"connection-timeout", &Settings::connection_timeout,
                        "Maximum time in milliseconds that wait-connection waits, then an error; 0 "
                        "= no limit"},
          gst::Property{"custom-lib", &Settings::custom_lib,
                        "Accepted for compatibility; connect-type=CUSTOM is not available"},
          gst::Property{"protocol", &Settings::protocol, "Protocol of the receivers"},
          gst::Property{"path", &Settings::path,
                        "File name of the Unix socket of the stream (protocol=local)"},
          gst::Property{"max-buffers", &Settings::max_buffers,
                        "Maximum number of buffers that a receiver has not released "
                        "(protocol=local), or that wait for a receiver (protocol=edge)",
                        gst::Changeable::InReady, 1u, kMaxBuffers},
          gst::Property{"drop", &Settings::drop,
                        "true = a receiver that has max-buffers misses buffers; false = the stream "
                        "waits for it; protocol=edge always drops"},
          gst::Property{"wire-version", &Settings::wire_version,
                        "Version of NNStreamer's library that receivers have (protocol=edge)"},
          gst::Property{"insecure", &Settings::insecure,
                        "Allow other machines to connect although weir.ini requires TLS"},
          gst::Property{"allow", &Settings::allow,
                        "Addresses and networks of receivers, separated by commas; default: all"},
      });

  Status start() {
    const Settings s = read_settings();
    if (auto status = check_edge_types(s.protocol, s.connect_type, kInfo.factory_name); !status)
      return status;
    auto output = s.protocol == EdgeProtocol::Local         ? open_local(s)
                  : s.connect_type == EdgeConnectType::Mqtt ? open_mqtt(s)
                                                            : open_tcp(s);
    if (!output) return output.error();
    if (s.connect_type == EdgeConnectType::Hybrid) {
      auto announcement =
          open_announcement(element(), broker(s), s.topic.value_or(""), s.host, taken_port_.load());
      if (!announcement) return announcement.error();
      announcement_ = *std::move(announcement);
      announced_ = false;
    }
    ledger_.reset();
    const std::lock_guard lock(output_mutex_);
    output_ = *std::move(output);
    return ok();
  }

  gboolean stop() {
    announcement_.reset();  // before the port is closed
    std::shared_ptr<BufferOutput> output;
    const std::lock_guard lock(output_mutex_);
    output.swap(output_);
    taken_port_ = 0;
    return TRUE;
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) has_waited_ = !settings().wait_connection;
    return gate_.change_state(self(), change, [&] {
      return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
    });
  }

  Status set_caps(GstCaps* caps) {
    if (auto status = output_->set_caps(caps); !status) return status;
    return announce();
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    Status ready = output_->set_no_caps();  // the stream may have none
    if (ready) ready = announce();
    Result<OutputOutcome> outcome = OutputOutcome::Interrupted;
    const GstFlowReturn flow = gate_.until_done(self(), [&] {
      outcome = ready ? wait_for_receiver() : ready.error();
      if (outcome && *outcome == OutputOutcome::Sent) outcome = output_->publish(buffer, &ledger_);
      return !outcome || *outcome != OutputOutcome::Interrupted;
    });
    if (flow != GST_FLOW_OK) {
      ledger_.dropped(DropReason::Flush);
      return flow;
    }
    if (!outcome) {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), outcome.error());
      return GST_FLOW_ERROR;
    }
    return count(*outcome);
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
    if (announcement_) announcement_->interrupt(true);
    return TRUE;
  }
  gboolean unlock_stop() {
    if (const auto output = current()) output->resume();
    if (announcement_) announcement_->interrupt(false);
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    if (const auto output = current()) output->add_stats(stats);
    gst_structure_set(stats, "port", G_TYPE_UINT, taken_port_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  Settings read_settings() const { return read_addresses(Element::settings()); }

  static constexpr uint32_t kMaxReceivers = 32, kMaxPerAddress = 16;
  static constexpr uint64_t kMaxTimeout = 1'000'000'000'000;  // ms

  using Opened = Result<std::unique_ptr<BufferOutput>>;

  Opened open_local(const Settings& s) {
    return open_local_output({.path = s.path,
                              .max_held = s.max_buffers,
                              .drop = s.drop,
                              .max_readers = kMaxReceivers,
                              .refused = [this](const Error& error) { log(error); }});
  }

  static EdgeBroker broker(const Settings& s) {
    return {.host = s.dest_host,
            .port = s.dest_port,
            .login = s,
            .insecure = s.insecure,
            .allow = s.allow};
  }

  Opened open_mqtt(const Settings& s) {
    auto options = open_options(element(), broker(s));
    if (!options) return options.error();
    return MqttOutput::open(
        {.broker = *std::move(options),
         .id = unique_device_id(),
         .topic = s.topic.value_or(""),
         .form = to_mqtt_form(s.wire_version),
         .outage = [this](const Error& error) { gst::post_warning(element(), error); }});
  }

  // Lets receivers find this element by the broker. Not before the caps are known, because a
  // receiver gets them only when it connects.
  Status announce() {
    if (!announcement_ || announced_) return ok();
    if (auto status = announcement_->announce(); !status)
      return status.error().code == Code::CANCELLED ? ok() : status;  // the next buffer does it
    announced_ = true;
    GST_CAT_INFO_OBJECT(category(), element(), "announced %s",
                        announcement_->address().to_string().c_str());
    return ok();
  }

  Opened open_tcp(const Settings& s) {
    if (auto status = check_plain_connection(element(), {.role = transport::Role::Listens,
                                                         .host = s.host,
                                                         .port = s.port,
                                                         .insecure = s.insecure,
                                                         .allow = s.allow});
        !status)
      return status.error();
    auto output = TcpOutput::open({.host = s.host,
                                   .port = s.port,
                                   .form = header_form(s.wire_version),
                                   .queue = {.frames = s.max_buffers},
                                   .max_subscribers = kMaxReceivers,
                                   .max_per_address = kMaxPerAddress,
                                   .allowed =
                                       [allow = s.allow](const std::string& address) {
                                         return transport::is_allowed(allow, address);
                                       },
                                   .refused = [this](const Error& error) { log(error); },
                                   .fallen_behind =
                                       [this, limit = s.max_buffers](const edge::Outage& outage) {
                                         gst::post_warning(element(), fallen_behind(outage, limit));
                                       }});
    if (!output) return output.error();
    taken_port_ = (*output)->port();
    GST_CAT_INFO_OBJECT(category(), element(), "listening on %s:%u", s.host.c_str(),
                        taken_port_.load());
    return std::unique_ptr<BufferOutput>(*std::move(output));
  }

  std::shared_ptr<BufferOutput> current() const {
    const std::lock_guard lock(output_mutex_);
    return output_;
  }

  void log(const Error& error) const {
    GST_CAT_WARNING_OBJECT(category(), element(), "%s", error.message().c_str());
  }

  // Sent = there is a receiver, or none is waited for.
  Result<OutputOutcome> wait_for_receiver() {
    if (has_waited_) return OutputOutcome::Sent;
    const uint64_t limit = settings().connection_timeout;
    io::Deadline deadline;
    if (limit > 0)
      deadline = io::deadline_in(
          std::chrono::milliseconds(static_cast<int64_t>(std::min(limit, kMaxTimeout))));
    has_waited_ = output_->wait_for_receiver(deadline);
    if (has_waited_) return OutputOutcome::Sent;
    if (!io::is_over(deadline)) return OutputOutcome::Interrupted;
    return Error{.code = Code::SERVER_UNREACHABLE,
                 .what = "no receiver connected within connection-timeout",
                 .offered = "connection-timeout=" + std::to_string(limit) + " ms",
                 .needed = "an edgesrc that connects in time",
                 .fix = "edgesink wait-connection=false"};
  }

  GstFlowReturn count(OutputOutcome outcome) {
    if (outcome == OutputOutcome::Sent)
      ledger_.consumed();
    else
      ledger_.dropped(DropReason::Policy);
    return GST_FLOW_OK;
  }

  mutable std::mutex output_mutex_;  // guards output_ while it changes
  std::shared_ptr<BufferOutput> output_;
  gst::PlayingGate gate_;
  std::unique_ptr<transport::ServerAnnouncement> announcement_;  // connect-type=HYBRID
  std::atomic<uint32_t> taken_port_{0};                          // 0 = it does not listen
  bool has_waited_ = false, announced_ = false;                  // streaming thread
};

}  // namespace

bool register_edgesink(GstPlugin* plugin) {
  return Edgesink::register_in(plugin);
}

}  // namespace weir
