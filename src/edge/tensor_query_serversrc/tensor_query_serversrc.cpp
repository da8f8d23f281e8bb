// tensor_query_serversrc: serves a pipeline; pushes the requests of clients as frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>

#include "edge/addresses.hpp"
#include "edge/edge_broker.hpp"
#include "edge/query_server.hpp"
#include "edge/query_server_registry.hpp"
#include "edge/request_meta.hpp"
#include "edge/request_watch.hpp"
#include "edge/serversrc_settings.hpp"
#include "edge/tensor_query_serversrc/edge_query_server.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "machine/install_command.hpp"
#include "transport/network_policy.hpp"

namespace weir {
namespace {

using gst::Ref;

std::string caps_as_text(const GstCaps* caps) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return text.get();
}

class TensorQueryServersrc : public gst::Element<TensorQueryServersrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorQueryServerSrc", "tensor_query_serversrc",
                                          "TensorQueryServerSrc", "Source/Tensor/Query",
                                          "Pushes the requests of clients as frames of tensors"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = ServersrcSettings;
  static constexpr std::tuple kProperties{
      gst::Property{"protocol", &Settings::protocol, "Protocol of the clients"},
      gst::Property{"host", &Settings::host, "Address to listen on"},
      gst::Property{
          "port", &Settings::port,
          "Port to listen on; 0 = a free port, which the property contains in PAUSED and PLAYING",
          gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"unix-path", &Settings::unix_path,
                    "Path of a Unix socket to listen on, instead of host and port"},
      gst::Property{"id", &Settings::id,
                    "Pairs this element with the tensor_query_serversink of the same id"},
      gst::Property{"caps", &Settings::caps,
                    "Caps of the requests; default: those that the downstream element requires"},
      gst::Property{"model-name", &Settings::model_name,
                    "Name of the model; default: the name of the next filter's model file, or this "
                    "element's name"},
      gst::Property{"model-version", &Settings::model_version, "Version of the model"},
      gst::Property{"queue", &Settings::queue,
                    "Maximum number of requests that wait for the pipeline; more are refused",
                    gst::Changeable::InReady, 1u, 65536u},
      gst::Property{"max-message", &Settings::max_message, "Maximum size of a message in bytes",
                    gst::Changeable::InReady, 1024u, 2147483647u},
      gst::Property{"max-requests", &Settings::max_requests,
                    "Maximum number of requests in progress of one connection; more are refused "
                    "(protocol=oip), or read when one ends (protocol=edge); 0 = no limit"},
      gst::Property{"max-connections", &Settings::max_connections,
                    "Maximum number of connections with requests in progress (protocol=oip), or of "
                    "clients (protocol=edge); more are refused; 0 = no limit"},
      gst::Property{"max-connections-per-address", &Settings::max_connections_per_address,
                    "As max-connections, for one address; 0 = no limit"},
      gst::Property{"max-bytes-in-flight", &Settings::max_bytes_in_flight,
                    "Maximum bytes of the requests in progress and of the unread answers of one "
                    "address; further requests wait or are refused; 0 = no limit"},
      gst::Property{"idle-timeout", &Settings::idle_timeout,
                    "Milliseconds after which a connection without calls is closed, and a call "
                    "ends whose answer the client has not read",
                    gst::Changeable::InReady, 1u, 2147483647u},
      gst::Property{"model-control", &Settings::model_control,
                    "Allow clients to unload the model and load it again; an unloaded model "
                    "refuses requests"},
      gst::Property{
          "insecure", &Settings::insecure,
          "Allow other machines to connect without TLS; use it only on a network that you trust"},
      gst::Property{"allow", &Settings::allow,
                    "Addresses and networks of clients, separated by commas (protocol=edge); "
                    "default: all"},
      gst::Property{"wire-version", &Settings::wire_version,
                    "Version of NNStreamer's library that clients have (protocol=edge); 0.2.6 also "
                    "serves clients of 0.2.4"},
      gst::Property{"tls-cert", &Settings::tls_cert,
                    "File with the certificate of this server (PEM); with tls-key it enables TLS"},
      gst::Property{"tls-key", &Settings::tls_key, "File with the key of tls-cert (PEM)"},
      gst::Property{"tls-ca", &Settings::tls_ca,
                    "File with the authority whose certificate each client needs (PEM)"},
      gst::Property{
          "tls-peers", &Settings::tls_peers,
          "Names of clients' certificates that are allowed, separated by commas; default: "
          "all of tls-ca"},
      gst::Property{"token-file", &Settings::token_file,
                    "File with one token per line; each client must send one; requires TLS"},
      gst::Property{"connect-type", &Settings::connect_type, "How clients find this server"},
      gst::Property{"dest-host", &Settings::dest_host,
                    "Address of the MQTT broker (connect-type=HYBRID); tls-ca, tls-cert and "
                    "tls-key apply to it"},
      gst::Property{"dest-port", &Settings::dest_port, "Port of the MQTT broker",
                    gst::Changeable::InReady, 0u, 65535u},
      gst::Property{"topic", &Settings::topic,
                    "Name under which the MQTT broker stores the address of this server"},
      gst::Property{"user", &Settings::user, "User name for the broker"},
      gst::Property{"password", &Settings::password, "Password for the broker"},
      gst::Property{"psk", &Settings::psk,
                    "Pre-shared key of the broker in hexadecimal digits; enables TLS without "
                    "certificates"},
      gst::Property{"psk-identity", &Settings::psk_identity, "Name of the key for the broker"},
      gst::Property{"timeout", &Settings::timeout,
                    "Maximum time in seconds that a client pauses within a message, does not read "
                    "its answers, or waits for the caps of the answers; after that it is closed; 0 "
                    "= no limit (protocol=edge)",
                    gst::Changeable::InReady, 0u, 3600u},
      gst::Property{"is-live", &Settings::is_live, "Whether the source is live"},
  };

  void constructed() {
    gst_base_src_set_live(base(), TRUE);
    gst_base_src_set_format(base(), GST_FORMAT_TIME);
    gst_base_src_set_do_timestamp(base(), TRUE);
    gst_pad_add_probe(
        pad(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM,
        [](GstPad*, GstPadProbeInfo* info, gpointer impl) {
          const auto* source = static_cast<TensorQueryServersrc*>(impl);
          // Others come on any thread.
          if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_EOS && source->server_)
            source->server_->close();
          return GST_PAD_PROBE_OK;
        },
        this, nullptr);
  }
  void property_changed(const char* name) {
    if (std::string_view(name) == "is-live") gst_base_src_set_live(base(), settings().is_live);
  }

  Status start() {
    const Settings s = read_settings();
    if (auto status = check_protocol(s.protocol, s.connect_type, kInfo.factory_name); !status)
      return status;
    auto server = open_server(s);
    if (!server) return server.error();
    id_ = s.id;
    wanted_port_ = s.port;
    ledger_.reset();
    if (auto status = register_server(id_, *server); !status) return status;
    if (auto status = (*server)->publish(); !status) {
      unregister_server(id_, **server);
      return status;
    }
    if (const uint32_t port = (*server)->port(); port != 0)
      change_settings([&](Settings& shown) { shown.port = port; });
    {
      std::lock_guard lock(server_mutex_);
      server_ = *std::move(server);
    }
    g_object_notify(G_OBJECT(self()), "port");
    GST_CAT_INFO_OBJECT(category(), self(), "%s", server_->description().c_str());
    if (s.protocol == QueryProtocol::Oip && s.insecure && s.tls_cert.empty())
      GST_CAT_WARNING_OBJECT(category(), self(),
                             "connections are not encrypted: anyone on the network can read and "
                             "change requests (insecure=true)");
    return ok();
  }

  // Downstream elements drop their frames before this element stops.
  GstStateChangeReturn change_state(GstStateChange change) {
    const bool pauses = change == GST_STATE_CHANGE_PLAYING_TO_PAUSED;
    if (server_ && (pauses || change == GST_STATE_CHANGE_PAUSED_TO_PLAYING)) {
      if (pauses) announcement_.reset();
      Status status = server_->set_running(!pauses);
      if (status && !pauses) status = announce();
      if (!status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
  }

  // The base class waits for the frame in work before it sends the end: clients are refused from
  // now on.
  gboolean send_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) {
      std::lock_guard lock(server_mutex_);
      if (server_) server_->close();
    }
    return GST_ELEMENT_CLASS(parent_class())->send_event(element(), event);
  }

  gboolean stop() {
    announcement_.reset();
    watch_.stop();
    watched_ = false;
    if (!server_) return TRUE;
    change_settings([&](Settings& shown) { shown.port = wanted_port_; });
    server_->stop();
    unregister_server(id_, *server_);
    GST_CAT_INFO_OBJECT(category(), self(), "%s", server_->summary().c_str());
    return TRUE;
  }

  // The caps are those that the downstream element needs: the base class would negotiate only what
  // this source can name itself. False also when a downstream element reported an error: no buffer
  // would come to report it again.
  gboolean negotiate() {
    const uint64_t errors = gst::errors_posted_by_this_thread();
    const Status status = agree_on_caps();
    if (!status) gst::post_error(element(), status.error());
    return status && gst::errors_posted_by_this_thread() == errors;
  }

  // Elements that need the first request for their caps report what they know by these.
  GstCaps* get_caps(GstCaps* filter) {
    auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad()));
    if (!caps) caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad()));
    return filter ? gst_caps_intersect_full(filter, caps.get(), GST_CAPS_INTERSECT_FIRST)
                  : caps.release();
  }

  // The frames have a pool of their own.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return TRUE;
  }

  GstFlowReturn create(GstBuffer** out) {
    if (!std::exchange(watched_, true)) watch_.start(pad());
    while (const auto request = server_->take()) {
      ledger_.received();
      auto buffer = server_->make_frame(*request);
      if (!buffer) {
        ledger_.dropped(DropReason::Error);
        log(buffer.error());
        continue;
      }
      request->set_source_id(id_);
      set_request(buffer->get(), request);
      gst::set_client(buffer->get(), request->client());
      request->pushed();
      ledger_.consumed_and_pushed();
      *out = buffer->release();
      return GST_FLOW_OK;
    }
    return GST_FLOW_FLUSHING;
  }

  // A flush may come while the element starts.
  gboolean unlock() {
    std::lock_guard lock(server_mutex_);
    if (server_) server_->interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    std::lock_guard lock(server_mutex_);
    if (server_) server_->resume();
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    std::lock_guard lock(server_mutex_);
    if (server_) server_->add_stats(stats);
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  Settings read_settings() const { return read_addresses(Element::settings()); }

  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }
  GstPad* pad() const { return GST_BASE_SRC_PAD(self()); }

  // "mobilenet" for the next filter's model=/models/mobilenet.tflite.
  std::string default_name() const {
    const std::string model = property_downstream(pad(), "model");
    const std::string file = model.substr(0, model.find(','));
    std::string stem = std::filesystem::path(file).stem();
    if (file.find("://") == std::string::npos && !stem.empty()) return stem;
    const gst::UniqueText name{gst_element_get_name(element())};
    return name.get();
  }

  Result<std::shared_ptr<QueryServer>> open_server(const Settings& s) const {
    return s.protocol == QueryProtocol::Edge ? open_edge(s) : open_oip(s);
  }
  Result<std::shared_ptr<QueryServer>> open_edge(const Settings& s) const {
    const auto warning = transport::check_old_protocol({.role = transport::Role::Listens,
                                                        .host = s.host,
                                                        .port = s.port,
                                                        .insecure = s.insecure,
                                                        .allow = s.allow},
                                                       config::Configuration::load());
    if (!warning) return warning.error();
    if (*warning) gst::post_warning(element(), **warning);
    return open_edge_query_server(s, [this](const Error& error) { log(error); });
  }
  void log(const Error& error) const {
    GST_CAT_WARNING_OBJECT(category(), self(), "%s", error.message().c_str());
  }
  // Lets the broker keep the address while clients are accepted.
  Status announce() {
    const Settings s = read_settings();
    if (s.connect_type != QueryConnectType::Hybrid) return ok();
    const EdgeBroker broker{.host = s.dest_host,
                            .port = s.dest_port,
                            .login = {.user = s.user,
                                      .password = s.password,
                                      .tls_ca = s.tls_ca,
                                      .tls_cert = s.tls_cert,
                                      .tls_key = s.tls_key,
                                      .psk = s.psk,
                                      .psk_identity = s.psk_identity},
                            .insecure = s.insecure,
                            .allow = s.allow};
    auto announcement = open_announcement(element(), broker, s.topic, s.host, server_->port());
    if (!announcement) return announcement.error();
    if (auto status = (*announcement)->announce(); !status) return status;
    announcement_ = *std::move(announcement);
    GST_CAT_INFO_OBJECT(category(), self(), "announced %s",
                        announcement_->address().to_string().c_str());
    return ok();
  }
  Result<std::shared_ptr<QueryServer>> open_oip(const Settings& s) const {
    if (!query_protocols().oip) {
      const auto loaded = Ref<GstPlugin>::adopt(gst_plugin_load_by_name("weirnet"));
      if (!loaded || !query_protocols().oip) return missing_plugin();
    }
    return query_protocols().oip.load()(s, default_name());
  }
  static Error missing_plugin() {
    return {
        .code = Code::MODULE_REFUSED,
        .what = "the plug-in weirnet, which serves the Open Inference Protocol, is not installed",
        .offered = "tensor_query_serversrc protocol=oip",
        .needed = "the plug-in weirnet, which Weir builds when gRPC is installed",
        .fix = std::string(install_command("apt-get install gstreamer1.0-weir-net",
                                           "apt-get install libgrpc++-dev && make install"))};
  }

  Status agree_on_caps() {
    auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad(), nullptr));
    if (const auto own = settings().caps)
      caps = Ref<GstCaps>::adopt(
          gst_caps_intersect_full(own.get(), caps.get(), GST_CAPS_INTERSECT_FIRST));
    if (gst_caps_is_empty(caps.get())) return rejected_caps();
    if (gst_caps_is_any(caps.get())) return unknown_caps();
    caps = Ref<GstCaps>::adopt(gst_caps_fixate(caps.release()));
    const auto names = parse_name_list(property_downstream(pad(), "inputname"));
    if (auto status = server_->set_input(caps.get(), names, buffer_limit_); !status) return status;
    if (!gst_base_src_set_caps(base(), caps.get())) return rejected_caps();
    gst_pad_push_event(pad(), make_server_event());
    const auto query = make_output_query(caps.get());
    const bool is_answered = gst_pad_peer_query(pad(), query.get());
    return is_answered ? ok() : server_->expect_output(nullptr, {});
  }
  Error rejected_caps() const {
    const auto own = settings().caps;
    const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad(), nullptr));
    return gst::downstream_mismatch(pad(), peer.get(),
                                    own ? caps_as_text(own.get()) : "any tensors",
                                    "caps that the downstream element accepts");
  }
  static Error unknown_caps() {
    return {
        .code = Code::OPTION_VALUE,
        .what = "the tensors of the requests are not known",
        .offered = "the downstream element accepts any caps",
        .needed = "the caps of the requests, or a downstream element that needs certain tensors",
        .fix =
            "caps=\"other/tensors,format=static,num_tensors=1,dimensions=(string)3:224:224:1,"
            "types=(string)uint8,framerate=0/1\""};
  }

  mutable std::mutex server_mutex_;  // guards server_ while it changes
  // Set in start().
  std::shared_ptr<QueryServer> server_;
  std::unique_ptr<transport::ServerAnnouncement> announcement_;  // connect-type=HYBRID
  uint32_t id_ = 0, wanted_port_ = 0;
  bool watched_ = false;
  RequestWatch watch_;
};

}  // namespace

bool register_tensor_query_serversrc(GstPlugin* plugin) {
  return TensorQueryServersrc::register_in(plugin);
}

}  // namespace weir
