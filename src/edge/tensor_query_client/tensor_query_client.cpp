// tensor_query_client: sends frames to a query server and pushes its responses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "core/wire/edge_capability.hpp"
#include "core/wire/peer_error.hpp"
#include "edge/addresses.hpp"
#include "edge/broker_login.hpp"
#include "edge/edge_broker.hpp"
#include "edge/serversrc_settings.hpp"
#include "edge/tensor_query_client/query_exchange.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/plain_filter.hpp"
#include "gstcpp/pads/early_events.hpp"
#include "transport/mqtt/server_finder.hpp"
#include "transport/wake_event.hpp"

namespace weir {
namespace {

using edge::LinkEnd;
using gst::Ref;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr char kRate[] = "framerate";

std::string caps_text(const GstCaps* caps) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return text.get();
}

Ref<GstCaps> without_rate(const GstCaps* caps) {
  auto out = Ref<GstCaps>::adopt(gst_caps_copy(caps));
  for (guint i = 0; i < gst_caps_get_size(out.get()); ++i)
    gst_structure_remove_field(gst_caps_get_structure(out.get(), i), kRate);
  return out;
}

// The same static tensors may be written in several ways: as other/tensor and other/tensors, and
// with more or fewer trailing 1s in their dimensions.
bool are_same_tensors(const GstCaps* a, const GstCaps* b) {
  const auto left = gst::spec_from_caps(a), right = gst::spec_from_caps(b);
  return left && right && left->format == Format::Static && left->info_valid() &&
         right->format == Format::Static && right->info_valid() &&
         first_difference(left->tensors, right->tensors).empty();
}

Result<Ref<GstCaps>> parse_caps(const std::string& text, const char* which) {
  const std::string what = std::string("the query server announces invalid caps for ") + which;
  auto caps = gst::caps_from_text(text);
  if (!caps) return wire::peer_error(what, caps.error());
  if (!gst_caps_is_empty(caps->get())) return caps;
  return wire::peer_error(what, wire::quoted_text(text), "valid caps");
}

// The caps of the responses to frames of `input`. A frame rate that the server leaves open is that
// of `input`. SPEC_MISMATCH if the server does not take `input`, whatever its frame rate;
// PEER_MESSAGE_INVALID if the server announces no caps, or several for its responses.
Result<Ref<GstCaps>> response_caps(const wire::QueryCapability& capability, const GstCaps* input) {
  const auto taken = parse_caps(capability.source_caps, "its input");
  if (!taken) return taken.error();
  const auto offered = without_rate(input), needed = without_rate(taken->get());
  if (!gst_caps_can_intersect(offered.get(), needed.get()) &&
      !are_same_tensors(offered.get(), needed.get()))
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the query server does not accept this stream",
                 .offered = caps_text(input),
                 .needed = caps_text(taken->get()),
                 .fix = "convert the stream upstream of tensor_query_client"};
  auto out = parse_caps(capability.sink_caps, "its answers");
  if (!out) return out;
  if (gst_caps_is_fixed(out->get())) return out;
  *out = Ref<GstCaps>::adopt(gst_caps_make_writable(out->release()));
  const GValue* rate = gst_structure_get_value(gst_caps_get_structure(input, 0), kRate);
  GstStructure* const response = gst_caps_get_structure(out->get(), 0);
  if (rate && gst_structure_has_field(response, kRate))
    gst_structure_set_value(response, kRate, rate);
  if (gst_caps_is_fixed(out->get())) return out;
  return wire::peer_error("the query server announces several caps for its answers",
                          wire::quoted_text(capability.sink_caps), "one: fixed caps",
                          "put a capsfilter upstream of its tensor_query_serversink");
}

struct QueryClientSettings : BrokerLogin {
  std::string host = "localhost";
  uint32_t port = 3001;
  std::string dest_host = "localhost";
  uint32_t dest_port = 3000;
  QueryConnectType connect_type = QueryConnectType::Tcp;
  std::optional<std::string> topic;
  uint32_t timeout = 0;
  bool silent = true;
  uint32_t max_request = 2;
  bool reconnect = false;
  uint64_t max_message = uint64_t{64} << 20;
  bool insecure = false;
  std::string allow;
};

class TensorQueryClient : public gst::PlainFilter<TensorQueryClient> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorQueryClient", "tensor_query_client",
                                          "TensorQueryClient", "Filter/Tensor/Query",
                                          "Sends frames to a query server and pushes its answers"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  using Settings = QueryClientSettings;
  static constexpr auto kProperties = std::tuple_cat(
      kBrokerLoginProperties,
      std::tuple{
          gst::Property{"host", &Settings::host,
                        "Address of this machine to which the server connects for its answers"},
          gst::Property{"port", &Settings::port,
                        "Port to which the server connects for its answers; 0 = a free port",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"dest-host", &Settings::dest_host,
                        "Address of the server, or of the MQTT broker"},
          gst::Property{"dest-port", &Settings::dest_port, "Port at dest-host",
                        gst::Changeable::InReady, 0u, 65535u},
          gst::Property{"connect-type", &Settings::connect_type,
                        "How the element finds the server"},
          gst::Property{"topic", &Settings::topic, "Name of the server at the MQTT broker"},
          gst::Property{
              "timeout", &Settings::timeout,
              "Milliseconds to wait for the answer to each frame; 0 = do not wait: answers "
              "are pushed when later frames arrive",
              gst::Changeable::WhilePlaying},
          gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                        gst::Changeable::WhilePlaying},
          gst::Property{
              "max-request", &Settings::max_request,
              "Drop a frame while more frames than this wait for their answers; 0 = no limit",
              gst::Changeable::WhilePlaying},
          gst::Property{"reconnect", &Settings::reconnect,
                        "true = drop frames and connect again while the server is unavailable; "
                        "false = that is an error"},
          gst::Property{"max-message", &Settings::max_message, "Maximum size of an answer in bytes",
                        gst::Changeable::InReady, uint64_t{1024}, uint64_t{1} << 40},
          gst::Property{"insecure", &Settings::insecure,
                        "Allow connections to other machines although weir.ini requires TLS"},
          gst::Property{"allow", &Settings::allow,
                        "Addresses and networks to which the element may connect, separated by "
                        "commas; default: all"},
      });

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      enter(Phase::Runs);
      interruption_.clear();
      if (auto status = start(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_PLAYING) enter(Phase::Runs);
    if (change == GST_STATE_CHANGE_PLAYING_TO_PAUSED) enter(Phase::Pauses);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) enter(Phase::Stops);
    return PlainFilter::change_state(change);
  }

  Status set_caps(GstCaps* caps) {
    if (input_caps_ && exchange_.is_connected() && gst_caps_is_equal(caps, input_caps_.get()))
      return ok();
    const bool may_wait = begin_negotiation();
    deliver(may_wait && settings().timeout > 0);
    exchange_.close(DropReason::Lost);
    input_caps_ = Ref<GstCaps>::share(caps);
    Status status = may_wait ? connect_or_retry() : ok();  // else the next frame connects
    end_negotiation();
    return status;
  }

  GstFlowReturn chain(Ref<GstBuffer> buffer) {
    if (!input_caps_) return failed(gst::buffer_before_caps());
    const Settings s = settings();
    const GstFlowReturn flow = make_ready();
    if (flow != GST_FLOW_OK || !exchange_.is_connected()) {
      ledger_.dropped(flow == GST_FLOW_OK ? DropReason::Lost : DropReason::Flush);
      return flow;
    }
    if (!exchange_.has_room(s.max_request)) {
      ledger_.dropped(DropReason::Policy);
      if (begins_outage()) gst::post_warning(element(), no_room());
      return GST_FLOW_OK;
    }
    const auto sent =
        exchange_.send(buffer.get(), s.timeout > 0 ? milliseconds(s.timeout) : kMaxResponseTime);
    buffer = {};
    if (!sent) return is_of_frame(sent.error()) ? post(sent.error()) : disconnected(sent.error());
    if (*sent == LinkEnd::Interrupted) return GST_FLOW_FLUSHING;
    if (*sent) return disconnected(server_gone(**sent));
    return deliver(s.timeout > 0);
  }

  void drain(DropReason reason) {
    if (reason == DropReason::Eos && exchange_.waiting() > 0) {
      is_ending_ = true;
      deliver(settings().timeout > 0);
      is_ending_ = false;
    }
    exchange_.close(reason);
    early_.clear();
    if (reason == DropReason::Eos) log_outcomes();
  }

  // Serialized events wait until caps are sent.
  bool sink_event(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_FLUSH_START) interruption_.set();
    if (type == GST_EVENT_FLUSH_STOP) interruption_.clear();
    if (type == GST_EVENT_SEGMENT) deliver(settings().timeout > 0);
    const bool serialized = gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED;
    // Others come on any thread.
    if (!serialized || output_caps_ || type <= GST_EVENT_CAPS || type == GST_EVENT_FLUSH_STOP ||
        type == GST_EVENT_EOS)
      return false;
    early_.push(Ref<GstEvent>::adopt(event));
    return true;
  }

  void reset() {
    input_caps_ = output_caps_ = {};
    finder_.reset();
    interruption_.clear();
  }

  void add_stats(GstStructure* stats) const {
    const auto counts = outcomes_.counts();
    gst_structure_set(stats, "sent", G_TYPE_UINT64, counts.sent, "answered", G_TYPE_UINT64,
                      counts.answered, "late", G_TYPE_UINT64, counts.late, "refused", G_TYPE_UINT64,
                      counts.refused, "lost", G_TYPE_UINT64, counts.lost, "reconnections",
                      G_TYPE_UINT64, reconnections_.load(), nullptr);
    for (const auto& [name, percent] : {std::pair{"p50-us", 50u}, {"p95-us", 95u}, {"p99-us", 99u}})
      if (const auto time = outcomes_.percentile(percent))
        gst_structure_set(
            stats, name, G_TYPE_INT64,
            gint64{std::chrono::duration_cast<std::chrono::microseconds>(*time).count()}, nullptr);
  }

  Settings settings_;

 private:
  Settings read_settings() const { return read_addresses(PlainFilter::settings()); }

  // The place of a request is freed after this time if `timeout` does not say.
  static constexpr milliseconds kMaxResponseTime{30'000};
  static constexpr milliseconds kQuiet{2000};  // without a loss: an outage is over
  static constexpr milliseconds kFirstRetry{100}, kLastRetry{1000}, kHandshake{10'000},
      kRetryHandshake{2000}, kServerTime{1000};

  enum class Phase : uint8_t { Runs, Pauses, Stops };
  void enter(Phase phase) {
    const std::lock_guard lock(phase_mutex_);
    phase_ = phase;
    if (phase == Phase::Stops || (phase == Phase::Pauses && is_negotiating_)) interruption_.set();
    if (phase == Phase::Runs && is_negotiating_) interruption_.clear();
  }
  // Whether set_caps() may wait: a live source does not pause before its caps are set.
  bool begin_negotiation() {
    const std::lock_guard lock(phase_mutex_);
    is_negotiating_ = phase_ != Phase::Pauses;
    return is_negotiating_;
  }
  void end_negotiation() {
    const std::lock_guard lock(phase_mutex_);
    if (std::exchange(is_negotiating_, false) && phase_ == Phase::Pauses) interruption_.clear();
  }

  Status start() {
    const Settings s = read_settings();
    outcomes_.reset();
    reconnections_ = 0;
    was_connected_ = false;
    has_answered_ = true;
    last_loss_ = {};
    retry_ = kFirstRetry;
    next_try_ = {};
    server_ = {{}, {s.dest_host, static_cast<uint16_t>(s.dest_port)}, 0};
    if (auto status = check_plain_connection(element(), {.role = transport::Role::Listens,
                                                         .host = s.host,
                                                         .port = s.port,
                                                         .insecure = s.insecure,
                                                         .allow = s.allow});
        !status)
      return status;
    if (s.connect_type == QueryConnectType::Hybrid) return open_finder(s);
    return check_server(s.dest_host, s.dest_port);
  }

  Status check_server(const std::string& host, uint32_t port) const {
    const Settings s = read_settings();
    return check_plain_server(
        element(), {.host = host, .port = port, .insecure = s.insecure, .allow = s.allow});
  }

  Status open_finder(const Settings& s) {
    auto options = open_options(element(), {.host = s.dest_host,
                                            .port = s.dest_port,
                                            .login = s,
                                            .insecure = s.insecure,
                                            .allow = s.allow});
    if (!options) return options.error();
    auto finder = transport::ServerFinder::open(*std::move(options), s.topic.value_or(""));
    if (!finder) return finder.error();
    finder_ = *std::move(finder);
    return ok();
  }

  // Tries the servers that the broker announces, oldest first. Until the first connection it waits
  // for one, as NNStreamer does; later frames are dropped while there is none.
  Status connect_to_any() {
    Status mismatch = ok();
    const io::Deadline now(steady_clock::now());
    for (;;) {
      const bool waits = !was_connected_ && mismatch;
      auto server = finder_->next(waits ? std::nullopt : now, interruption_.descriptor());
      if (!server) return mismatch ? Status(server.error()) : mismatch;
      server_ = *std::move(server);
      auto status = connect_to_announced();
      if (status || is_of_this_element(status.error().code)) return status;
      finder_->failed(server_);
      gst::post_warning(element(), while_reconnecting(status.error()));
      if (!was_connected_ && status.error().code == Code::SPEC_MISMATCH)
        mismatch = std::move(status);
    }
  }
  // Another server would not help.
  static bool is_of_this_element(Code code) {
    return code == Code::CANCELLED || code == Code::OPTION_VALUE;
  }
  Status connect_to_announced() {
    const auto& [host, port] = server_.address;
    auto status = check_server(host, port);
    return status ? connect_to_server(kServerTime) : status;
  }

  // Connects to `server_`.
  Status connect_to_server(milliseconds time) {
    const Settings s = read_settings();
    auto link = edge::QueryLink::connect({.host = s.host,
                                          .port = s.port,
                                          .server_host = server_.address.host,
                                          .server_port = server_.address.port,
                                          .limits = {.message_bytes = s.max_message},
                                          .cancel = interruption_.descriptor(),
                                          .handshake_time = time});
    if (!link) return link.error();
    const auto caps = response_caps((*link)->capability(), input_caps_.get());
    if (!caps) return caps.error();
    const bool are_new = !output_caps_ || !gst_caps_is_equal(caps->get(), output_caps_.get());
    if (are_new)
      if (auto status = gst::check_downstream(source_, caps->get(), ""); !status) return status;
    if (auto status = (*link)->confirm(io::deadline_in(time)); !status) return status;
    exchange_.open(*std::move(link), input_caps_.get(), caps->get());
    if (std::exchange(was_connected_, true)) ++reconnections_;
    retry_ = kFirstRetry;
    GST_CAT_INFO_OBJECT(category(), element(), "connected to %s, answers are %" GST_PTR_FORMAT,
                        server_.address.to_string().c_str(), static_cast<void*>(caps->get()));
    if (are_new) send_caps(*caps);
    return ok();
  }

  void send_caps(const Ref<GstCaps>& caps) {
    output_caps_ = caps;
    gst_pad_push_event(source_, gst_event_new_caps(output_caps_.get()));
    early_.send(source_);
  }

  // Whether frames are dropped while no server is there.
  bool outlives_servers() const { return finder_ || settings().reconnect; }

  // A server that is not there may be no error: chain() tries again.
  Status connect_or_retry() {
    if (steady_clock::now() < next_try_) return ok();
    Status status = finder_ ? connect_to_any()
                            : connect_to_server(was_connected_ ? kRetryHandshake : kHandshake);
    if (status || status.error().code == Code::CANCELLED) return ok();
    const Code code = status.error().code;
    const bool may_come = code == Code::SERVER_UNREACHABLE || code == Code::SERVER_REFUSED ||
                          code == Code::PEER_MESSAGE_INVALID;
    if (!may_come || !outlives_servers()) return status;
    if (retry_ == kFirstRetry) gst::post_warning(element(), while_reconnecting(status.error()));
    next_try_ = steady_clock::now() + retry_;
    retry_ = std::min(2 * retry_, kLastRetry);
    return ok();
  }

  // Pushes the responses that are there, and connects if there is no connection.
  GstFlowReturn make_ready() {
    const GstFlowReturn flow = deliver(false);
    if (flow != GST_FLOW_OK || exchange_.is_connected()) return flow;
    if (auto status = connect_or_retry(); !status) return post(status.error());
    return GST_FLOW_OK;
  }

  // Pushes responses; with `wait` until each frame that was sent has its response or has timed out.
  GstFlowReturn deliver(bool wait) {
    while (exchange_.is_connected()) {
      auto event = exchange_.next(wait, settings().max_request);
      if (!event) return disconnected(event.error());
      if (!event->end) {
        has_answered_ = true;
        const auto flow = gst_pad_push(source_, event->response.release());
        if (flow != GST_FLOW_OK) return flow;
        continue;
      }
      if (*event->end == LinkEnd::Late) break;
      if (*event->end == LinkEnd::Interrupted) return GST_FLOW_FLUSHING;
      if (*event->end != LinkEnd::OutOfStep) return disconnected(server_gone(*event->end));
      responses_are_missing();
    }
    return GST_FLOW_OK;
  }

  // Errors of edge::QueryLink::make_request() and of reading the buffer.
  static bool is_of_frame(const Error& error) { return error.code != Code::PEER_MESSAGE_INVALID; }

  GstFlowReturn post(const Error& error) {
    gst::post_error(element(), error);
    return error.code == Code::SPEC_MISMATCH ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
  }

  GstFlowReturn disconnected(const Error& error) {
    exchange_.close(DropReason::Lost);
    if (finder_) finder_->failed(server_);
    if (!outlives_servers() && !is_ending_) return post(error);
    gst::post_warning(element(), while_reconnecting(error));
    return GST_FLOW_OK;
  }

  // Called for each frame that is lost: whether a warning is due, one for each outage. An outage
  // ends when the server has answered and nothing was lost for a while.
  bool begins_outage() {
    const auto now = steady_clock::now();
    const bool is_new = has_answered_ && now - last_loss_ > kQuiet;
    last_loss_ = now;
    has_answered_ = false;
    return is_new;
  }

  Error no_room() const {
    return Error{
        .code = Code::SERVER_UNREACHABLE,
        .what = "the query server does not answer in time: frames are dropped",
        .offered = server_.address.to_string() +
                   ", frames that wait for an answer: " + std::to_string(exchange_.waiting()),
        .needed = "a server that answers as fast as frames come; max-request is " +
                  std::to_string(settings().max_request),
        .fix =
            "tensor_rate framerate=5/1 ! tensor_query_client for a server that is slow; start "
            "one that does not answer at all again"};
  }

  // The error for a user who need not set `reconnect` any more.
  Error while_reconnecting(Error error) const {
    if (outlives_servers() && error.fix.find("reconnect=true") != std::string::npos)
      error.fix = "tensor_query_serversrc port=" + std::to_string(server_.address.port) +
                  " ! ... ! tensor_query_serversink at " + server_.address.host +
                  ": when it plays, this client connects automatically";
    return error;
  }

  // Only a new connection makes clear which response is whose.
  void responses_are_missing() {
    exchange_.close(DropReason::Late);
    if (finder_) finder_->failed(server_);
    const Error error{
        .code = Code::SERVER_UNREACHABLE,
        .what = "several answers in a row were late: the client reconnects",
        .offered =
            server_.address.to_string() + ", timeout=" + std::to_string(settings().timeout) + " ms",
        .needed = "a timeout longer than the time that the server needs",
        .fix = "tensor_query_client timeout=1000, or timeout=0, which does not wait for answers"};
    if (begins_outage()) return gst::post_warning(element(), error);
    GST_CAT_WARNING_OBJECT(category(), element(), "%s", error.message().c_str());
  }

  Error server_gone(LinkEnd end) const {
    return Error{.code = Code::SERVER_UNREACHABLE,
                 .what = end == LinkEnd::Refused ? "the query server has ended the connection"
                                                 : "the connection to the query server was lost",
                 .offered = server_.address.to_string(),
                 .needed = "a server that runs as long as the stream",
                 .fix = "tensor_query_client reconnect=true, which connects again"};
  }

  void log_outcomes() const {
    const auto counts = outcomes_.counts();
    GST_CAT_INFO_OBJECT(category(), element(),
                        "%" G_GUINT64_FORMAT " sent: %" G_GUINT64_FORMAT
                        " answered, %" G_GUINT64_FORMAT " late, %" G_GUINT64_FORMAT
                        " refused, %" G_GUINT64_FORMAT " lost",
                        counts.sent, counts.answered, counts.late, counts.refused, counts.lost);
  }

  transport::WakeEvent interruption_;
  std::mutex phase_mutex_;  // guards the next two
  Phase phase_ = Phase::Runs;
  bool is_negotiating_ = false;
  edge::RequestOutcomes outcomes_;
  std::atomic<uint64_t> reconnections_{0};
  // Streaming thread, or a change of state that has stopped it.
  QueryExchange exchange_{&ledger_, &outcomes_};
  Ref<GstCaps> input_caps_, output_caps_;
  std::unique_ptr<transport::ServerFinder> finder_;  // connect-type=HYBRID
  transport::ServerFinder::Server server_{};         // the last one that was tried
  gst::EarlyEvents early_;                           // until there are caps to send
  bool was_connected_ = false, is_ending_ = false;
  bool has_answered_ = true;  // since last_loss_
  steady_clock::time_point last_loss_;
  milliseconds retry_ = kFirstRetry;
  steady_clock::time_point next_try_;
};

}  // namespace

bool register_tensor_query_client(GstPlugin* plugin) {
  return TensorQueryClient::register_in(plugin);
}

}  // namespace weir
