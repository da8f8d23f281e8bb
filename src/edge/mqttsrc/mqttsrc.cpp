// mqttsrc: pushes the messages of a topic of an MQTT broker as buffers, with their caps and times.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "core/text/shell_quote.hpp"
#include "edge/mqtt_element.hpp"
#include "edge/mqtt_meta.hpp"
#include "edge/mqttsrc/received_frame.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "transport/mqtt/ntp_time.hpp"

namespace weir {
namespace {

using gst::Ref;
using transport::BrokerClient;
using transport::MqttMessage;
using Payload = std::vector<std::byte>;

constexpr char kOnePublisher[] = "set sub-topic to the topic of one publisher";

// What makes a message unusable.
enum class Invalid { Message, Caps };

// One memory for each size; all of them keep the payload.
void append_memories(GstBuffer* buffer, Payload payload, const MqttFrameHeader& frame) {
  auto* owned = new Payload(std::move(payload));
  GstMemory* whole = gst_memory_new_wrapped(
      GST_MEMORY_FLAG_READONLY, owned->data(), owned->size(), 0, owned->size(), owned,
      [](gpointer bytes) { delete static_cast<Payload*>(bytes); });
  size_t offset = frame.offset;
  for (const size_t size : frame.sizes) {
    gst_buffer_append_memory(
        buffer, gst_memory_share(whole, static_cast<gssize>(offset), static_cast<gssize>(size)));
    offset += size;
  }
  gst_memory_unref(whole);
}

class MqttSrc : public MqttElement<MqttSrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirMqttSrc", "mqttsrc", "MQTT source", "Source/MQTT",
                                          "Receives a stream from a topic of an MQTT broker"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  struct Settings : BrokerSettings {
    std::optional<std::string> sub_topic;
    int64_t sub_timeout = 10'000'000;
    int mqtt_qos = 2;
    bool is_live = true, keep_stored = false;
  };
  static constexpr auto kProperties = std::tuple_cat(
      kBrokerProperties,
      std::tuple{
          gst::Property{"sub-topic", &Settings::sub_topic,
                        "Topic to subscribe to; may contain the wildcards + and #",
                        kAtTheNextStart},
          gst::Property{"sub-timeout", &Settings::sub_timeout,
                        "Microseconds without a message after which the stream fails",
                        kAtTheNextStart, int64_t{1'000'000}, INT64_MAX},
          gst::Property{
              "mqtt-qos", &Settings::mqtt_qos,
              "Quality of service of MQTT: 0 = at most once, 1 = at least once, 2 = exactly once",
              kAtTheNextStart, 0, 2},
          gst::Property{"is-live", &Settings::is_live, "Whether the source is live",
                        kAtTheNextStart},
          gst::Property{"keep-stored", &Settings::keep_stored,
                        "Push messages that were sent before this stream began, which the broker "
                        "stored for a client with mqtt-qos=1 or 2 and cleansession=false, without "
                        "timestamps; false = drop them"}});

  void constructed() {
    gst_base_src_set_live(base(), TRUE);
    gst_base_src_set_format(base(), GST_FORMAT_TIME);
  }
  void property_changed(const char* name) {
    if (std::string_view(name) == "is-live") gst_base_src_set_live(base(), settings().is_live);
  }

  Status start() {
    if (settings().client_id.empty())
      change_settings([](Settings& s) { s.client_id = default_client_id("src"); });
    active_ = settings();
    if (auto status = transport::check_topic_filter("sub-topic", active_.sub_topic.value_or(""));
        !status)
      return status;
    auto options = broker_options(active_);
    if (!options) return options.error();
    if (auto status = check_connection(element(), *options, active_); !status) return status;
    options->on_invalid_packet = [this](const Error& error) {
      gst::post_warning(element(), error);
    };
    auto client = BrokerClient::open(*std::move(options));
    if (!client) return client.error();
    if (auto status = (*client)->subscribe(*active_.sub_topic, active_.mqtt_qos); !status)
      return status;
    ledger_.reset();
    caps_.clear();
    next_.clear();
    lost_ = invalid_ = gone_ = overflowed_ = 0;
    has_warned_ = {};
    set_client(*std::move(client));
    return ok();
  }
  gboolean negotiate() { return TRUE; }  // the caps come with the messages

  GstFlowReturn create(GstBuffer** out) {
    std::optional<GstFlowReturn> flow;
    while (!flow) flow = take_message(out);
    return *flow;
  }

  void add_stats(GstStructure* stats) const {
    const auto c = counts();
    gst_structure_set(stats, "connections", G_TYPE_UINT64, c.connections, "messages-lost",
                      G_TYPE_UINT64, lost_.load(), "messages-invalid", G_TYPE_UINT64,
                      invalid_.load(), "senders-gone", G_TYPE_UINT64, gone_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }

  // Nothing if the message is dropped.
  std::optional<GstFlowReturn> take_message(GstBuffer** out) {
    auto message = client_->receive(std::chrono::milliseconds(active_.sub_timeout / 1000));
    if (interrupted_) return flushing(message.has_value());
    count_overflow();
    if (!message) {
      gst::post_error(element(), no_message());
      return GST_FLOW_ERROR;
    }
    ledger_.received();
    auto frame = read(*message);
    if (!frame) return std::nullopt;
    if (frame->caps != caps_ || caps_.empty()) {
      const auto caps = read_caps(*message, frame->caps);
      if (!caps) return std::nullopt;
      if (!change_caps(caps.get(), frame->caps)) return GST_FLOW_NOT_NEGOTIATED;
    }
    *out = make_buffer(*std::move(message), *frame);
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  Error no_message() const {
    return {.code = Code::BROKER_UNREACHABLE,
            .what = "no message came from the broker",
            .offered = "nothing on the topic " + *active_.sub_topic + " for " +
                       std::to_string(active_.sub_timeout) + " microseconds",
            .needed = "a publisher, for example mqttsink pub-topic=" + *active_.sub_topic,
            .fix = "start the publisher first, or raise sub-timeout"};
  }

  GstFlowReturn flushing(bool has_message) {
    if (has_message) {
      ledger_.received();
      ledger_.dropped(DropReason::Flush);
    }
    return GST_FLOW_FLUSHING;
  }

  // Messages that the client dropped because this element was slower.
  void count_overflow() {
    const uint64_t dropped = client_->counts().dropped;
    for (; overflowed_ < dropped; ++overflowed_) {
      ledger_.received();
      ledger_.dropped(DropReason::Policy);
    }
  }

  // Nullopt, counted, for a message that is not pushed.
  std::optional<MqttFrameHeader> read(const MqttMessage& message) {
    const int64_t now = transport::unix_time();
    update_base_epoch(now);
    auto frame = active_.is_v5() ? frame_from_properties(message, base_epoch_)
                                 : frame_from_header(message, base_epoch_);
    if (!frame) {
      reject(message, frame.error());
      return std::nullopt;
    }
    count_gap(message.topic, *frame);
    const bool late = active_.is_v5() && active_.max_age > 0 &&
                      now - frame->sent_epoch > int64_t{active_.max_age} * 1'000'000;
    if (late || !(frame->on_time || active_.keep_stored)) {
      ledger_.dropped(late ? DropReason::Late : DropReason::Time);
      GST_CAT_DEBUG_OBJECT(category(), self(), "a message of %s is dropped: %s",
                           quoted_text(message.topic).c_str(),
                           late ? "it is older than max-age" : "it was sent before this stream");
      return std::nullopt;
    }
    return *std::move(frame);
  }
  void reject(const MqttMessage& message, const Error& error) {
    const bool gone =
        active_.is_v5() && message.payload.size() == 4 &&
        std::string_view(reinterpret_cast<const char*>(message.payload.data()), 4) == "gone";
    if (!gone) return drop_invalid(Invalid::Message, message, error);
    ++gone_;
    ledger_.dropped(DropReason::Eos);
    GST_CAT_WARNING_OBJECT(category(), self(),
                           "topic %s: a publisher lost its connection to the broker",
                           quoted_text(message.topic).c_str());
  }
  // Everyone who may publish can send such a message, and the broker repeats a retained one at each
  // start, so it does not end the stream. Posts the first of a kind as a warning.
  void drop_invalid(Invalid kind, const MqttMessage& message, Error error) {
    ++invalid_;
    ledger_.dropped(DropReason::Error);
    error.what =
        "a message of the topic " + quoted_text(message.topic) + " is dropped: " + error.what;
    if (!std::exchange(has_warned_[static_cast<size_t>(kind)], true))
      return gst::post_warning(element(), error);
    GST_CAT_DEBUG_OBJECT(category(), self(), "%s", error.message().c_str());
  }
  // Each publisher numbers its messages; a new base epoch is a new stream.
  void count_gap(const std::string& topic, const MqttFrameHeader& frame) {
    if (!frame.sequence) return;
    constexpr size_t kMaxStreams = 1024;
    if (next_.size() >= kMaxStreams) next_.clear();
    auto [stream, first] = next_.try_emplace(topic, frame.base_epoch, *frame.sequence);
    auto& [epoch, next] = stream->second;
    if (!first && epoch == frame.base_epoch && *frame.sequence > next)
      lost_ += *frame.sequence - next;
    epoch = frame.base_epoch;
    next = *frame.sequence + 1;
  }

  // Null, counted, for a message whose caps cannot be used.
  Ref<GstCaps> read_caps(const MqttMessage& message, const std::string& text) {
    auto caps = gst::caps_from_text(text);
    if (caps && gst_caps_is_fixed(caps->get())) return *std::move(caps);
    drop_invalid(Invalid::Caps, message,
                 Error{.code = Code::PEER_MESSAGE_INVALID,
                       .what = "its caps cannot be used",
                       .offered = caps ? quoted_text(text) : caps.error().offered,
                       .needed = caps ? "fixed caps of one format" : caps.error().needed,
                       .difference = caps ? "" : caps.error().difference,
                       .fix = kOnePublisher});
    return {};
  }
  bool change_caps(GstCaps* caps, const std::string& text) {
    if (gst_base_src_set_caps(base(), caps)) {
      caps_ = text;
      return true;
    }
    ledger_.dropped(DropReason::Error);
    gst::post_error(element(), Error{.code = Code::SPEC_MISMATCH,
                                     .what = "the downstream element rejects the caps of a message",
                                     .offered = text,
                                     .needed = "caps that the downstream element accepts",
                                     .fix = kOnePublisher});
    return false;
  }

  static GstBuffer* make_buffer(MqttMessage message, const MqttFrameHeader& frame) {
    GstBuffer* buffer = gst_buffer_new();
    append_memories(buffer, std::move(message.payload), frame);
    GST_BUFFER_PTS(buffer) = frame.pts.value_or(GST_CLOCK_TIME_NONE);
    GST_BUFFER_DTS(buffer) = frame.dts.value_or(GST_CLOCK_TIME_NONE);
    GST_BUFFER_DURATION(buffer) = frame.duration.value_or(GST_CLOCK_TIME_NONE);
    set_mqtt_meta(buffer, message.properties);
    return buffer;
  }

  Settings active_;  // set in start(); streaming thread
  std::string caps_;
  std::map<std::string, std::pair<int64_t, uint64_t>> next_;  // base epoch and number, by topic
  std::atomic<uint64_t> lost_{0}, invalid_{0}, gone_{0};
  std::array<bool, 2> has_warned_{};  // of each kind of Invalid; streaming thread
  uint64_t overflowed_ = 0;
};

}  // namespace

bool register_mqttsrc(GstPlugin* plugin) {
  return MqttSrc::register_in(plugin);
}

}  // namespace weir
