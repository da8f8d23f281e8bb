// edgesrc: pushes the buffers that an edgesink of another process sends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <poll.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "edge/addresses.hpp"
#include "edge/broker_login.hpp"
#include "edge/edge_broker.hpp"
#include "edge/edge_connect_type.hpp"
#include "edge/edgesrc/mqtt_input.hpp"
#include "edge/edgesrc/tcp_input.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "transport/mqtt/server_finder.hpp"
#include "transport/wake_event.hpp"

namespace weir {
namespace {

using gst::Ref;
using InputKind = InputEvent::Kind;

struct Example {
  const char* media_type;
  const char* fields;
  const char* downstream;
};
constexpr Example kExamples[] = {
    {"other/tensors", "format=flexible,framerate=30/1", "tensor_sink"},
    {"video/x-raw", "format=RGB,width=640,height=480,framerate=30/1",
     "videoconvert ! autovideosink"},
    {"audio/x-raw", "format=S16LE,layout=interleaved,rate=16000,channels=1",
     "audioconvert ! autoaudiosink"},
};

std::string example_for(GstPad* pad) {
  const auto accepted = gst::Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad, nullptr));
  if (!accepted || gst_caps_is_any(accepted.get())) return "edgesrc ! CAPS ! fakesink";
  for (const auto& example : kExamples) {
    const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_new_empty_simple(example.media_type));
    if (gst_caps_can_intersect(accepted.get(), caps.get()))
      return std::string("edgesrc ! ") + example.media_type + "," + example.fields + " ! " +
             example.downstream;
  }
  return "edgesrc ! CAPS ! fakesink";
}

// For an edgesink that did not announce its caps. The fix has caps that the peer of `pad` accepts.
Error unknown_caps(GstPad* pad) {
  return Error{.code = Code::NOT_NEGOTIATED,
               .what = "the caps of the stream are not known",
               .offered = "an edgesink that did not announce its caps",
               .needed =
                   "a capsfilter with fixed caps, those of the sink pad of the edgesink: "
                   "gst-launch-1.0 -v prints them",
               .fix = example_for(pad)};
}

struct EdgesrcSettings : BrokerLogin {
  std::optional<std::string> host;
  uint32_t port = 0;
  std::string dest_host = "localhost";
  uint32_t dest_port = 3000;
  EdgeConnectType connect_type = EdgeConnectType::Tcp;
  std::optional<std::string> topic, custom_lib;
  EdgeProtocol protocol = EdgeProtocol::Edge;
  std::string path;
  bool reconnect = false;
  uint64_t max_message = uint64_t{64} << 20;
  bool insecure = false;
  std::string allow;
};

class Edgesrc : public gst::Element<Edgesrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirEdgeSrc", "edgesrc", "EdgeSrc", "Source/Edge",
                                          "Pushes the buffers that an edgesink sends"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = EdgesrcSettings;
  static constexpr auto kProperties = std::tuple_cat(
      kBrokerLoginProperties,
      std::tuple{
          gst::Property{"host", &Settings::host, "Deprecated; has no effect"},
          gst::Property{"port", &Settings::port, "Deprecated; has no effect",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"dest-host", &Settings::dest_host,
                        "Address of the edgesink, or of the MQTT broker"},
          gst::Property{"dest-port", &Settings::dest_port, "Port at dest-host",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"connect-type", &Settings::connect_type,
                        "How the element finds the edgesink"},
          gst::Property{"topic", &Settings::topic, "Name of the stream at the MQTT broker"},
          gst::Property{"custom-lib", &Settings::custom_lib,
                        "Accepted for compatibility; connect-type=CUSTOM is not available"},
          gst::Property{"protocol", &Settings::protocol, "Protocol of the edgesink"},
          gst::Property{"path", &Settings::path, "Path of the edgesink (protocol=local)"},
          gst::Property{
              "reconnect", &Settings::reconnect,
              "true = wait for the next edgesink; false = a missing or lost edgesink is an error"},
          gst::Property{"max-message", &Settings::max_message,
                        "Maximum size of a message in bytes (protocol=edge)",
                        gst::Changeable::InReady, uint64_t{1024}, uint64_t{1} << 40},
          gst::Property{"insecure", &Settings::insecure,
                        "Allow connections to other machines although weir.ini requires TLS"},
          gst::Property{"allow", &Settings::allow,
                        "Addresses and networks to which the element may connect, separated by "
                        "commas; default: all"},
      });

  void constructed() { gst_base_src_set_format(base(), GST_FORMAT_TIME); }

  Status start() {
    const Settings s = read_settings();
    if (auto status = check_edge_types(s.protocol, s.connect_type, kInfo.factory_name); !status)
      return status;
    warn_of_deprecated(s);
    ledger_.reset();
    has_warned_ = false;
    refused_ = 0;
    reconnections_ = 0;
    was_connected_ = false;
    caps_ = {};
    if (s.protocol == EdgeProtocol::Edge && s.connect_type == EdgeConnectType::Tcp)
      if (auto status = check_network(s.dest_host, s.dest_port); !status) return status;
    if (s.connect_type == EdgeConnectType::Hybrid && !s.reconnect)
      return open_finder(s);  // the streaming thread waits for servers
    if (s.reconnect) return ok();
    return connect(s);
  }

  gboolean stop() {
    set_input(nullptr);
    finder_.reset();
    return TRUE;
  }

  // The caps come from the edgesink.
  gboolean negotiate() { return TRUE; }

  GstFlowReturn create(GstBuffer** out) {
    for (;;) {
      auto event = next();
      if (!event) return failed(event.error());
      switch (event->kind) {
        case InputKind::Silent:
          gst::post_warning(element(), silent());
          break;
        case InputKind::Buffer:
          count_connection();
          if (!caps_ && !set_caps_of_downstream()) return GST_FLOW_NOT_NEGOTIATED;
          ledger_.copied(event->copied);
          return take(event->buffer.release(), out);
        case InputKind::End:
          return GST_FLOW_EOS;
        case InputKind::Interrupted:
          return GST_FLOW_FLUSHING;
        case InputKind::Caps:
          count_connection();
          if (!set_caps(event->caps)) return GST_FLOW_NOT_NEGOTIATED;
          break;
        case InputKind::Lost:
          if (!may_replace_lost_server()) return failed(lost());
          break;
      }
    }
  }

  gboolean unlock() {
    interruption_.set();
    const std::lock_guard lock(input_mutex_);
    if (input_) input_->interrupt(true);
    return TRUE;
  }
  gboolean unlock_stop() {
    interruption_.clear();
    const std::lock_guard lock(input_mutex_);
    if (input_) input_->interrupt(false);
    return TRUE;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "reconnections", G_TYPE_UINT64, reconnections_.load(), "refused",
                      G_TYPE_UINT64, refused_.load(), nullptr);
    const std::lock_guard lock(input_mutex_);
    if (input_) input_->add_stats(stats);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  Settings read_settings() const { return read_addresses(Element::settings()); }

  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }
  GstPad* pad() const { return GST_BASE_SRC_PAD(self()); }

  void warn_of_deprecated(const Settings& s) const {
    if (!s.host && s.port == 0) return;
    gst::post_warning(
        element(), Error{.code = Code::OPTION_VALUE,
                         .what = "the properties host and port of edgesrc have no effect",
                         .offered = s.host ? "host=" + *s.host : "port=" + std::to_string(s.port),
                         .needed = "the address of the edgesink in dest-host and dest-port",
                         .fix = "edgesrc dest-host=localhost dest-port=3000"});
  }

  Status check_network(const std::string& host, uint32_t port) const {
    const Settings s = read_settings();
    return check_plain_server(
        element(), {.host = host, .port = port, .insecure = s.insecure, .allow = s.allow});
  }

  Result<transport::BrokerOptions> broker(const Settings& s) const {
    return open_options(element(), {.host = s.dest_host,
                                    .port = s.dest_port,
                                    .login = s,
                                    .insecure = s.insecure,
                                    .allow = s.allow});
  }

  Status open_finder(const Settings& s) {
    auto options = broker(s);
    if (!options) return options.error();
    auto finder = transport::ServerFinder::open(*std::move(options), s.topic.value_or(""));
    if (!finder) return finder.error();
    finder_ = *std::move(finder);
    return ok();
  }

  using Opened = Result<std::unique_ptr<BufferInput>>;

  Opened open_input(const Settings& s) {
    const int interruption = interruption_.descriptor();
    if (s.protocol == EdgeProtocol::Local) return connect_local_input(s.path, interruption);
    if (s.connect_type == EdgeConnectType::Mqtt) return open_mqtt(s);
    if (s.connect_type == EdgeConnectType::Hybrid) return find_and_connect(s);
    return TcpInput::open(s.dest_host, s.dest_port, s.max_message, TcpInput::Times(), interruption);
  }

  Opened open_mqtt(const Settings& s) {
    auto options = broker(s);
    if (!options) return options.error();
    return MqttInput::connect({.broker = *std::move(options),
                               .topic = s.topic.value_or(""),
                               .max_bytes = s.max_message,
                               .interruption = interruption_.descriptor(),
                               .refused = [this](const Error& error) { refuse(error); }});
  }

  // Tries the servers that the broker announces until one greets.
  Opened find_and_connect(const Settings& s) {
    if (!finder_)
      if (auto status = open_finder(s); !status) return status.error();
    for (;;) {
      auto server = finder_->next(std::nullopt, interruption_.descriptor());
      if (!server) return server.error();
      server_ = *std::move(server);
      const auto& [host, port] = server_.address;
      const auto allowed = check_network(host, port);
      auto input = allowed ? TcpInput::connect(host, port, s.max_message, kServerTimes,
                                               interruption_.descriptor())
                           : Opened(allowed.error());
      if (input || input.error().code == Code::CANCELLED) return input;
      finder_->failed(server_);
      refuse(input.error());
    }
  }

  // Counts a server or a message that the stream goes on without. The first one is posted.
  void refuse(Error error) {
    ++refused_;
    if (finder_ && error.fix.find("reconnect=true") != std::string::npos)
      error.fix = "edgesink connect-type=HYBRID topic=" + settings().topic.value_or("") +
                  ": when it plays, this edgesrc connects automatically";
    if (!std::exchange(has_warned_, true)) return gst::post_warning(element(), error);
    GST_CAT_WARNING_OBJECT(category(), element(), "%s", error.message().c_str());
  }

  void set_input(std::unique_ptr<BufferInput> input) {
    const std::lock_guard lock(input_mutex_);
    input_.swap(input);
  }

  Status connect(const Settings& s) {
    auto input = open_input(s);
    if (!input) return input.error();
    set_input(*std::move(input));
    if (caps_) input_->set_caps(caps_.get());
    is_new_ = is_discontinuous_ = true;
    return ok();
  }

  // An edgesink that closes the connection before it sends something does not count.
  void count_connection() {
    if (std::exchange(is_new_, false) && std::exchange(was_connected_, true)) ++reconnections_;
  }

  // Closes the connection.
  bool may_replace_lost_server() {
    set_input(nullptr);
    if (!finder_) return settings().reconnect;
    finder_->failed(server_);
    return true;
  }

  // Whether an edgesink that starts later ends the error.
  static bool is_of_absent_server(const Error& error) {
    return error.code == Code::SERVER_UNREACHABLE || error.code == Code::SERVER_REFUSED ||
           error.code == Code::BROKER_UNREACHABLE;
  }

  // Connects if necessary.
  Result<InputEvent> receive(const Settings& s) {
    if (!input_)
      if (auto status = connect(s); !status) return status.error();
    auto event = input_->receive();
    if (event || !finder_ || event.error().code == Code::CANCELLED) return event;
    refuse(event.error());  // another server may send what can be used
    return InputEvent{InputKind::Lost};
  }

  // With `reconnect` it waits for the edgesink.
  Result<InputEvent> next() {
    const Settings s = read_settings();
    for (;;) {
      auto event = receive(s);
      if (event) return event;
      const Error& error = event.error();
      if (error.code == Code::CANCELLED) return InputEvent{InputKind::Interrupted};
      if (!s.reconnect || !is_of_absent_server(error)) return event;
      set_input(nullptr);
      pollfd watched{interruption_.descriptor(), POLLIN, 0};
      if (poll(&watched, 1, kRetryMilliseconds) > 0) return InputEvent{InputKind::Interrupted};
    }
  }

  GstFlowReturn failed(const Error& error) {
    set_input(nullptr);
    gst::post_error(element(), error);
    return GST_FLOW_ERROR;
  }

  Error silent() const {
    const Settings s = read_settings();
    return {.code = Code::SERVER_UNREACHABLE,
            .what = "the edgesink has not announced its caps for 10 seconds",
            .offered = s.dest_host + ":" + std::to_string(s.dest_port),
            .needed = "an edgesink whose stream has started; edgesrc continues to wait"};
  }

  Error lost() const {
    const Settings s = read_settings();
    const bool is_local = s.protocol == EdgeProtocol::Local;
    return {
        .code = Code::SERVER_UNREACHABLE,
        .what = "the edgesink has closed the connection",
        .offered = is_local ? "path=" + s.path : s.dest_host + ":" + std::to_string(s.dest_port),
        .needed = is_local
                      ? "an edgesink that ends its stream with EOS"
                      : "an edgesink that keeps running: its protocol cannot signal the end of a "
                        "stream; the fix waits for the next edgesink",
        .fix = "reconnect=true"};
  }

  bool set_caps(const Ref<GstCaps>& caps) {
    if (caps_ && gst_caps_is_equal(caps_.get(), caps.get())) return true;
    const auto status = gst::check_downstream(pad(), caps.get(), "");
    if (!status) {
      // NNStreamer's protocol leaves the caps to the capsfilter.
      if (settings().protocol == EdgeProtocol::Edge && fixed_caps_of_downstream()) {
        gst::post_warning(element(), status.error());
        return set_caps_of_downstream();
      }
      gst::post_error(element(), status.error());
      return false;
    }
    caps_ = caps;
    input_->set_caps(caps.get());
    return gst_base_src_set_caps(base(), caps.get());
  }

  // Null if downstream accepts more than one.
  Ref<GstCaps> fixed_caps_of_downstream() const {
    auto caps = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad(), nullptr));
    if (!caps || !gst_caps_is_fixed(caps.get())) return {};
    return caps;
  }

  // For an edgesink that did not announce its caps.
  bool set_caps_of_downstream() {
    auto caps = fixed_caps_of_downstream();
    if (!caps) {
      gst::post_error(element(), unknown_caps(pad()));
      return false;
    }
    caps_ = caps;
    input_->set_caps(caps.get());
    return gst_base_src_set_caps(base(), caps.get());
  }

  GstFlowReturn take(GstBuffer* buffer, GstBuffer** out) {
    ledger_.received();
    // GstBaseSrc sets the time of a buffer that has none, once there is a clock.
    if (gst_base_src_get_do_timestamp(base()))
      GST_BUFFER_PTS(buffer) = GST_BUFFER_DTS(buffer) =
          is_before_playing() ? 0 : GST_CLOCK_TIME_NONE;
    if (std::exchange(is_discontinuous_, false))
      GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
    ledger_.consumed_and_pushed();
    *out = buffer;
    return GST_FLOW_OK;
  }

  // The running time is 0 until the pipeline has been in PLAYING.
  bool is_before_playing() const {
    return GST_STATE(element()) != GST_STATE_PLAYING && gst_element_get_base_time(element()) == 0;
  }

  static constexpr int kRetryMilliseconds = 50;
  // A server may have left its address behind.
  static constexpr TcpInput::Times kServerTimes{.connect = std::chrono::seconds(1),
                                                .greet = std::chrono::seconds(2)};

  transport::WakeEvent interruption_;
  std::atomic<uint64_t> reconnections_{0}, refused_{0};
  mutable std::mutex input_mutex_;  // guards input_ while it changes
  // Streaming thread, or start() and stop().
  std::unique_ptr<BufferInput> input_;
  std::unique_ptr<transport::ServerFinder> finder_;  // connect-type=HYBRID
  transport::ServerFinder::Server server_{};         // that input_ is of
  Ref<GstCaps> caps_;
  bool was_connected_ = false, is_new_ = false, is_discontinuous_ = false, has_warned_ = false;
};

}  // namespace

bool register_edgesrc(GstPlugin* plugin) {
  return Edgesrc::register_in(plugin);
}

}  // namespace weir
