// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/tensor_query_serversrc/edge_query_server.hpp"

#include <gst/audio/audio.h>
#include <gst/video/video.h>

#include <optional>
#include <utility>

#include "edge/message_buffer.hpp"
#include "edge/message_memories.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/mapped_video.hpp"
#include "gstcpp/buffer/query_meta.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "transport/edge/query_listener.hpp"
#include "transport/network_policy.hpp"

namespace weir {
namespace {

using gst::Ref;
using Outcome = edge::Request::Outcome;

constexpr auto kMaxRequestFlush = std::chrono::milliseconds(500);

edge::ListenerOptions listener_options(const ServersrcSettings& s,
                                       std::function<void(const Error&)> report) {
  edge::ListenerOptions out{
      .host = s.host,
      .port = s.port,
      .client = {.max_message_bytes = s.max_message, .timeout = std::chrono::seconds(s.timeout)},
      .max_requests = s.max_requests,
      .max_address_bytes = s.max_bytes_in_flight,
      .max_clients = s.max_connections,
      .max_per_address = s.max_connections_per_address,
      .allowed =
          [allow = s.allow](const auto& address) { return transport::is_allowed(allow, address); },
      .refused = std::move(report)};
  // Without a form, the server also speaks that of 0.2.4.
  if (s.wire_version != WireVersion::Bytes2088) out.client.form = header_form(s.wire_version);
  if (!s.allow.empty()) out.client.allows_callback = out.allowed;
  return out;
}

// Bytes of one sample of every channel; 0 if it is not known.
size_t sample_bytes(const GstStructure* audio) {
  const char* format = gst_structure_get_string(audio, "format");
  int channels = 0;
  if (!format || !gst_structure_get_int(audio, "channels", &channels) || channels < 0) return 0;
  const auto* info = gst_audio_format_get_info(gst_audio_format_from_string(format));
  return GST_AUDIO_FORMAT_INFO_WIDTH(info) / 8 * static_cast<size_t>(channels);
}

// What frames of these caps must be, beyond what their elements can report without an end of the
// stream: a client must not be able to end it.
class FrameCheck {
 public:
  void set_caps(const GstCaps* caps) {
    const auto spec = gst::spec_from_caps(caps);
    has_tensors_ = spec.has_value();
    sample_bytes_ = 0;
    video_.reset();
    if (spec)
      spec_ = *spec;
    else
      set_medium(caps);
  }
  Status check(GstBuffer* buffer) {
    const size_t size = gst_buffer_get_size(buffer);
    if (!has_tensors_) return check_medium(size);
    const size_t tensors = spec_.tensors.size();  // none in flexible streams
    if (tensors > 0 && tensors <= kMemoryLimit)
      if (auto status = gst::whole_frame(spec_, size); !status) return status;
    return layout_.locate(buffer, spec_);
  }

 private:
  void set_medium(const GstCaps* caps) {
    const GstStructure* medium = gst_caps_get_structure(caps, 0);
    GstVideoInfo video;
    if (gst_structure_has_name(medium, "audio/x-raw"))
      sample_bytes_ = sample_bytes(medium);
    else if (gst_structure_has_name(medium, "video/x-raw") &&
             gst_video_info_from_caps(&video, caps) && GST_VIDEO_INFO_SIZE(&video) > 0)
      video_ = video;
  }
  Status check_medium(size_t size) const {
    if (video_) return gst::check_video_size(*video_, size);
    if (sample_bytes_ > 0 && size % sample_bytes_ != 0)
      return gst::wrong_frame_size(std::to_string(size) + " bytes",
                                   "a multiple of " + std::to_string(sample_bytes_) + " bytes");
    return ok();
  }

  bool has_tensors_ = false;
  FrameSpec spec_;  // of the input
  gst::FrameLayout layout_;
  size_t sample_bytes_ = 0;  // 0: not known
  std::optional<GstVideoInfo> video_;
};

class EdgeQueryServer : public QueryServer {
 public:
  EdgeQueryServer(std::unique_ptr<edge::QueryListener> listener, std::string host)
      : listener_(std::move(listener)), host_(std::move(host)) {}

  Status publish() override { return ok(); }
  uint32_t port() const override { return listener_->port(); }
  std::string description() const override {
    return "listening on " + host_ + ":" + std::to_string(port());
  }
  Status set_input(GstCaps* caps, const std::vector<std::string>&,
                   const BufferLimit& limit) override {
    if (const auto spec = gst::fixed_spec_from_caps(caps))
      if (auto status = limit.check(*spec); !status) return status;
    buffers_.set_caps(caps);
    check_.set_caps(caps);
    limit_ = &limit;
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return listener_->set_request_caps(text.get());
  }
  Status set_output(GstCaps* caps, const std::vector<std::string>&,
                    const DescribedModel*) override {
    mapper_.set_caps(caps);
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return listener_->set_response_caps(text.get());
  }
  Status expect_output(GstCaps* caps, const std::vector<std::string>&) override {
    if (!caps) return ok();
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return listener_->expect_response_caps(text.get());
  }
  std::shared_ptr<QueryRequest> take() override { return listener_->take(); }
  void interrupt() override { listener_->interrupt(); }
  void resume() override { listener_->resume(); }

  // A client that sends what it was not asked for is closed: it would take the response to its next
  // request for that of this one.
  Result<Ref<GstBuffer>> make_frame(QueryRequest& request) override {
    auto& received = static_cast<edge::Request&>(request);  // of take()
    uint64_t copied = 0;
    auto buffer = buffers_.make(std::move(received.memories()), &copied);
    auto status = buffer ? check_.check(buffer->get()) : Status(buffer.error());
    if (status) status = limit_->check(gst_buffer_get_size(buffer->get()));
    if (status) return buffer;
    received.end(Outcome::Refused);
    listener_->refuse(received.client(), status.error().message());
    return status.error();
  }
  Result<Delivery> respond(QueryRequest* request, GstBuffer* buffer, uint64_t*) override {
    const auto client = gst::get_client_id(buffer);
    auto* own = dynamic_cast<edge::Request*>(request);
    if (request && !own) return Delivery::OtherServer;
    if (!client && !own) return Delivery::NoRequest;
    auto mapped = mapper_.map(buffer);
    if (!mapped) return mapped.error();
    const auto sent = listener_->respond(client ? *client : own->client(), mapped->memories,
                                         std::move(mapped->owner), own ? own->sequence() : "");
    if (sent != edge::QueryListener::Sent::Queued) return Delivery::Lost;
    if (own) own->end(Outcome::Answered);
    return Delivery::Sent;
  }
  Status set_running(bool running) override {
    if (!running) listener_->flush(io::deadline_in(kMaxRequestFlush));
    listener_->set_accepting(running);
    return ok();
  }
  void close() override { listener_->close(); }
  void stop() override {
    listener_->flush(io::deadline_in(kMaxRequestFlush));
    listener_->stop();
  }
  std::string summary() const override {
    const auto& c = listener_->requests();
    return "requests: " + std::to_string(c.received) + " received = " + std::to_string(c.answered) +
           " answered + " + std::to_string(c.refused) + " refused + " + std::to_string(c.expired) +
           " expired + " + std::to_string(c.aborted) + " aborted";
  }
  void add_stats(GstStructure* stats) const override {
    const auto& c = listener_->requests();
    const auto counts = listener_->counts();
    // The ends before the sum, so that the difference is not negative.
    const uint64_t answered = c.answered, refused = c.refused, expired = c.expired,
                   aborted = c.aborted, received = c.received;
    gst_structure_set(stats, "requests-received", G_TYPE_UINT64, received, "requests-answered",
                      G_TYPE_UINT64, answered, "requests-refused", G_TYPE_UINT64, refused,
                      "requests-expired", G_TYPE_UINT64, expired, "requests-aborted", G_TYPE_UINT64,
                      aborted, "requests-in-flight", G_TYPE_UINT64,
                      received - answered - refused - expired - aborted, "answers-lost",
                      G_TYPE_UINT64, counts.answers_lost, "clients", G_TYPE_UINT, counts.clients,
                      "clients-refused", G_TYPE_UINT64, counts.clients_refused, nullptr);
  }

 private:
  const std::unique_ptr<edge::QueryListener> listener_;
  const std::string host_;
  // The source's streaming thread.
  MessageBuffers buffers_;
  FrameCheck check_;
  const BufferLimit* limit_ = nullptr;  // the source's
  // The sink's streaming thread.
  MemoryMapper mapper_;
};

}  // namespace

Result<std::shared_ptr<QueryServer>> open_edge_query_server(
    const ServersrcSettings& s, std::function<void(const Error&)> report) {
  auto listener = edge::QueryListener::open(listener_options(s, std::move(report)));
  if (!listener) return listener.error();
  return std::shared_ptr<QueryServer>(
      std::make_shared<EdgeQueryServer>(*std::move(listener), s.host));
}

}  // namespace weir
