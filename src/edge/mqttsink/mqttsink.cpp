// mqttsink: publishes each buffer, with its caps and times, to a topic of an MQTT broker.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <cstring>

#include "core/text/shell_quote.hpp"
#include "core/wire/mqtt_header.hpp"
#include "edge/mqtt_element.hpp"
#include "edge/mqtt_meta.hpp"
#include "gstcpp/element/playing_gate.hpp"
#include "transport/mqtt/ntp_time.hpp"

namespace weir {
namespace {

using namespace std::chrono_literals;
using transport::BrokerClient;
using transport::Publication;

std::optional<uint64_t> valid(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? std::optional<uint64_t>(time) : std::nullopt;
}

class MappedMemories {
 public:
  explicit MappedMemories(GstBuffer* buffer) {
    for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
      GstMemory* memory = gst_buffer_peek_memory(buffer, i);
      GstMapInfo map;
      if (!gst_memory_map(memory, &map, GST_MAP_READ)) {
        failed_ = true;
        return;
      }
      maps_.push_back(map);
    }
  }
  MappedMemories(const MappedMemories&) = delete;
  MappedMemories& operator=(const MappedMemories&) = delete;
  ~MappedMemories() {
    for (auto& map : maps_) gst_memory_unmap(map.memory, &map);
  }
  bool failed() const { return failed_; }
  std::vector<std::span<const std::byte>> spans() const {
    std::vector<std::span<const std::byte>> out;
    for (const auto& map : maps_)
      out.emplace_back(reinterpret_cast<const std::byte*>(map.data), map.size);
    return out;
  }

 private:
  std::vector<GstMapInfo> maps_;
  bool failed_ = false;
};

class MqttSink : public MqttElement<MqttSink, gst::BaseSink> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirMqttSink", "mqttsink", "MQTT sink", "Sink/MQTT",
                                          "Publishes a stream to a topic of an MQTT broker"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };

  struct Settings : BrokerSettings {
    std::string pub_topic, ntp_srvs = "pool.ntp.org:123", response_topic;
    uint64_t pub_wait_timeout = 1, max_buffer_size = 0;
    int num_buffers = -1, mqtt_qos = 0;
    bool ntp_sync = false;
  };
  static constexpr auto kProperties = std::tuple_cat(
      kBrokerProperties,
      std::tuple{
          gst::Property{"pub-topic", &Settings::pub_topic,
                        "Topic to publish to; default: client-id/topic", kAtTheNextStart},
          gst::Property{"pub-wait-timeout", &Settings::pub_wait_timeout,
                        "Maximum time in seconds until the broker accepts a message; after that "
                        "the message is dropped",
                        kAtTheNextStart, uint64_t{1}, UINT64_MAX},
          gst::Property{"num-buffers", &Settings::num_buffers,
                        "Number of buffers to publish before EOS; -1 = no limit",
                        gst::Changeable::WhilePlaying, -1, INT32_MAX},
          gst::Property{"max-buffer-size", &Settings::max_buffer_size,
                        "Largest buffer in bytes; a larger one is an error; 0 = no limit",
                        kAtTheNextStart},
          gst::Property{
              "mqtt-qos", &Settings::mqtt_qos,
              "Quality of service of MQTT: 0 = at most once, 1 = at least once, 2 = exactly once",
              kAtTheNextStart, 0, 2},
          gst::Property{"ntp-sync", &Settings::ntp_sync,
                        "Send the time of the servers in ntp-srvs instead of this machine's",
                        kAtTheNextStart},
          gst::Property{"ntp-srvs", &Settings::ntp_srvs,
                        "NTP servers for ntp-sync: host:port,host:port", kAtTheNextStart},
          gst::Property{
              "response-topic", &Settings::response_topic,
              "Topic for answers (protocol=5); each message has its number as correlation data"}});

  void constructed() { gst_base_sink_set_sync(GST_BASE_SINK(self()), FALSE); }
  void property_changed(const char* name) {
    if (std::string_view(name) == "num-buffers") num_buffers_ = settings().num_buffers;
  }

  Status start() {
    if (settings().client_id.empty())
      change_settings([](Settings& s) { s.client_id = default_client_id("sink"); });
    if (settings().pub_topic.empty())
      change_settings([](Settings& s) { s.pub_topic = s.client_id + "/topic"; });
    active_ = settings();
    if (auto status = transport::check_topic("pub-topic", active_.pub_topic); !status)
      return status;
    if (!active_.response_topic.empty())
      if (auto status = transport::check_topic("response-topic", active_.response_topic); !status)
        return status;
    auto options = broker_options(active_);
    if (!options) return options.error();
    if (auto status = check_connection(element(), *options, active_); !status) return status;
    options->on_invalid_packet = [this](const Error& error) {
      gst::post_warning(element(), error);
    };
    const auto gone = std::as_bytes(std::span("gone", 4));
    if (active_.is_v5())
      options->will = transport::MqttWill{
          .topic = active_.pub_topic, .payload = {gone.begin(), gone.end()}, .retain = false};
    ntp_offset_ = 0;
    if (active_.ntp_sync) {
      const auto offset = transport::ntp_offset(active_.ntp_srvs, 1s);
      if (!offset) return offset.error();
      ntp_offset_ = *offset;
    }
    auto client = BrokerClient::open(*std::move(options));
    if (!client) return client.error();
    ledger_.reset();
    outage_ = false;
    invalid_responses_ = 0;
    set_client(*std::move(client));
    return ok();
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) sequence_ = 0;
    return gate_.change_state(self(), change, [&] { return MqttElement::change_state(change); });
  }

  Status set_caps(GstCaps* caps) {
    const gst::UniqueText text{gst_caps_to_string(caps)};
    caps_ = text.get();
    media_type_ = gst_caps_is_any(caps) || gst_caps_is_empty(caps)
                      ? ""
                      : gst_structure_get_name(gst_caps_get_structure(caps, 0));
    return ok();
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    const int limit = num_buffers_;  // may change while the stream runs
    if (limit >= 0 && sequence_ >= static_cast<uint64_t>(limit)) {
      ledger_.dropped(DropReason::Eos);
      return GST_FLOW_EOS;
    }
    Status status = ok();
    const GstFlowReturn flow = gate_.until_done(self(), [&] {
      status = publish(buffer);
      return status || status.error().code != Code::CANCELLED;
    });
    if (flow != GST_FLOW_OK) {
      ledger_.dropped(DropReason::Flush);
      return flow;
    }
    if (status) {
      outage_ = false;
      ledger_.consumed();
    } else if (status.error().code == Code::BROKER_UNREACHABLE) {
      ledger_.dropped(DropReason::Lost);
      if (!std::exchange(outage_, true)) gst::post_warning(element(), status.error());
    } else if (status.error().code == Code::PEER_MESSAGE_INVALID) {
      ledger_.dropped(DropReason::Error);
      ++invalid_responses_;
      ++sequence_;
      GST_CAT_WARNING_OBJECT(category(), self(), "%s", status.error().message().c_str());
    } else {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), status.error());
      return GST_FLOW_ERROR;
    }
    const bool last = limit > 0 && sequence_ == static_cast<uint64_t>(limit);
    return last ? GST_FLOW_EOS : GST_FLOW_OK;
  }

  gboolean event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_EOS && client_ && !client_->flush(wait_time()))
      GST_CAT_WARNING_OBJECT(category(), self(), "the broker has not acknowledged all messages");
    return parent_class()->event(self(), event);
  }

  void add_stats(GstStructure* stats) const {
    const auto c = counts();
    gst_structure_set(stats, "connections", G_TYPE_UINT64, c.connections, "messages-published",
                      G_TYPE_UINT64, c.published, "messages-refused", G_TYPE_UINT64, c.refused,
                      "messages-lost", G_TYPE_UINT64, c.lost, "answers-invalid", G_TYPE_UINT64,
                      invalid_responses_.load(), nullptr);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  std::chrono::milliseconds wait_time() const {
    return std::chrono::seconds(std::min<uint64_t>(active_.pub_wait_timeout, 1'000'000));
  }

  Status publish(GstBuffer* buffer) {
    const size_t size = gst_buffer_get_size(buffer);
    if (size == 0)
      return Error{.code = Code::FRAME_SIZE,
                   .what = "a buffer is empty",
                   .offered = "0 bytes",
                   .needed = "at least one byte",
                   .fix = "check the upstream element"};
    if (active_.max_buffer_size > 0 && size > active_.max_buffer_size)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "a buffer is larger than mqttsink may publish",
                   .offered = std::to_string(size) + " bytes",
                   .needed = "at most " + std::to_string(active_.max_buffer_size) + " bytes",
                   .fix = "max-buffer-size=" + std::to_string(size) + ", or 0 for no limit"};
    const MappedMemories mapped(buffer);
    if (mapped.failed())
      return Error{.code = Code::MAPPING_FAILED, .what = "a memory of a buffer cannot be read"};
    const int64_t now = transport::unix_time() + ntp_offset_;
    update_base_epoch(now);
    auto status = active_.is_v5() ? publish_v5(buffer, mapped.spans(), now)
                                  : publish_v311(buffer, mapped.spans(), now);
    if (status) ++sequence_;
    return status;
  }

  Status publish_v311(GstBuffer* buffer, const std::vector<std::span<const std::byte>>& memories,
                      int64_t now) {
    wire::MqttHeader header{.base_time_epoch = base_epoch_,
                            .sent_time_epoch = now,
                            .duration = valid(GST_BUFFER_DURATION(buffer)),
                            .dts = valid(GST_BUFFER_DTS(buffer)),
                            .pts = valid(GST_BUFFER_PTS(buffer)),
                            .caps = caps_};
    for (const auto& memory : memories) header.sizes.push_back(memory.size());
    const auto bytes = wire::write_mqtt_header(header);
    if (!bytes) return bytes.error();
    // Assigned, not moved: payload_ keeps its memory from frame to frame.
    payload_.assign(bytes->begin(), bytes->end());
    append(memories);
    return client_->publish({.topic = active_.pub_topic,
                             .payload = payload_,
                             .qos = active_.mqtt_qos,
                             .retain = true,
                             .properties = {}},
                            wait_time());
  }

  Status publish_v5(GstBuffer* buffer, const std::vector<std::span<const std::byte>>& memories,
                    int64_t now) {
    Publication out{.topic = active_.pub_topic, .qos = active_.mqtt_qos};
    auto& properties = out.properties;
    read_mqtt_meta(buffer, &properties);
    const bool is_response = !properties.response_topic.empty();
    if (is_response) out.topic = std::exchange(properties.response_topic, "");
    if (!is_response && !active_.response_topic.empty()) {
      properties.response_topic = active_.response_topic;
      const std::string number = std::to_string(sequence_);
      const auto bytes = std::as_bytes(std::span(number));
      properties.correlation_data.assign(bytes.begin(), bytes.end());
    }
    add_user_properties(buffer, memories, now, &properties);
    payload_.clear();
    if (memories.size() == 1)
      out.payload = memories[0];
    else
      append(memories);
    if (memories.size() != 1) out.payload = payload_;
    if (is_response && !transport::check_topic("response-topic", out.topic)) {
      return Error{.code = Code::PEER_MESSAGE_INVALID,
                   .what = "an answer is dropped: its request has no valid response topic",
                   .offered = quoted_text(out.topic),
                   .needed =
                       "a topic of 1 to 65535 bytes of UTF-8 without the wildcards + and #, "
                       "and without NUL",
                   .fix = "mqttsink response-topic=answers, in the pipeline that asks"};
    }
    return client_->publish(out, wait_time());
  }

  void add_user_properties(GstBuffer* buffer,
                           const std::vector<std::span<const std::byte>>& memories, int64_t now,
                           transport::MqttProperties* properties) const {
    properties->content_type = media_type_;
    if (active_.max_age > 0) properties->expiry = (active_.max_age + 999) / 1000;
    const auto add = [&](const char* name, const auto& value) {
      properties->user.emplace_back(name, std::to_string(value));
    };
    properties->user.emplace_back("caps", caps_);
    if (const auto pts = valid(GST_BUFFER_PTS(buffer))) add("pts", *pts);
    if (const auto duration = valid(GST_BUFFER_DURATION(buffer))) add("dur", *duration);
    add("base-epoch", base_epoch_);
    add("sent-epoch", now);
    add("seq", sequence_);
    if (memories.size() < 2) return;
    std::string sizes;
    for (const auto& memory : memories)
      sizes += (sizes.empty() ? "" : ",") + std::to_string(memory.size());
    properties->user.emplace_back("sizes", sizes);
  }

  void append(const std::vector<std::span<const std::byte>>& memories) {
    size_t size = payload_.size();
    for (const auto& memory : memories) size += memory.size();
    ledger_.copied(size - payload_.size());
    payload_.reserve(size);
    for (const auto& memory : memories)
      payload_.insert(payload_.end(), memory.begin(), memory.end());
  }

  Settings active_;  // set in start(); streaming thread
  std::atomic<int> num_buffers_{Settings().num_buffers};
  gst::PlayingGate gate_;
  std::string caps_, media_type_;
  std::vector<std::byte> payload_;
  int64_t ntp_offset_ = 0;
  uint64_t sequence_ = 0;
  std::atomic<uint64_t> invalid_responses_{0};  // to requests without a topic to send them to
  bool outage_ = false;
};

}  // namespace

bool register_mqttsink(GstPlugin* plugin) {
  return MqttSink::register_in(plugin);
}

}  // namespace weir
