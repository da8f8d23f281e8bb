// tensor_sink_grpc: sends each frame of tensors as a message of NNStreamer's TensorService.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <new>

#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/playing_gate.hpp"
#include "net-elements/grpc_element.hpp"

namespace weir {
namespace {

using net::OutgoingFrames;
using Outcome = OutgoingFrames::Outcome;

constexpr std::chrono::seconds kMaxTimeToEnd{5};  // to send what is queued at EOS
constexpr std::align_val_t kMessageAlignment{64};

// Memory of a message, which several calls may send at a time.
class MessageMemory {
 public:
  explicit MessageMemory(size_t bytes)
      : size_(bytes), data_(static_cast<std::byte*>(::operator new(bytes, kMessageAlignment))) {}
  MessageMemory(const MessageMemory&) = delete;
  MessageMemory& operator=(const MessageMemory&) = delete;
  ~MessageMemory() { ::operator delete(data_, kMessageAlignment); }
  std::byte* data() const { return data_; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const size_t size_;
  std::byte* const data_;
};

class TensorSinkGrpc : public GrpcElement<TensorSinkGrpc, gst::BaseSink, OutgoingFrames> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSinkGrpc", "tensor_sink_grpc",
                                          "TensorSinkGRPC", "Sink/Network",
                                          "Sends frames of tensors to other programs by gRPC"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_GRPC)),
  };

  uint32_t out() const { return static_cast<uint32_t>(ledger_.snapshot().consumed); }

  using Settings = GrpcSettings;
  static constexpr auto kProperties = std::tuple_cat(
      kGrpcProperties,
      std::tuple{
          gst::Property{"server", &Settings::server,
                        "true = clients connect and receive the frames; false = the element "
                        "connects to a server and sends them"},
          gst::Property{"blocking", &Settings::blocking,
                        "true = wait while no peer has room for the frame; false = drop the frame"},
          gst::ReadOnly{"out", &TensorSinkGrpc::out, "Number of frames that were sent or queued"},
          gst::Property{"queue", &Settings::queue,
                        "Maximum number of frames that wait for each peer",
                        gst::Changeable::InReady, 1u, 65536u}});

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED)
      if (const Status status = open(); !status) {
        gst::post_error(element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
    const auto result = gate_.change_state(self(), change, [&] {
      return GST_ELEMENT_CLASS(parent_class())->change_state(element(), change);
    });
    const bool failed = result == GST_STATE_CHANGE_FAILURE;
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY ||
        (change == GST_STATE_CHANGE_READY_TO_PAUSED && failed))
      close();
    return result;
  }

  Status set_caps(GstCaps* caps) {
    auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    spec_ = *std::move(spec);
    return ok();
  }

  GstFlowReturn render(GstBuffer* buffer) {
    ledger_.received();
    auto message = encode(buffer);
    if (!message) return failed(message.error());
    Outcome outcome{};
    const GstFlowReturn flow = gate_.until_done(self(), [&] {
      outcome = frames_->send(*message);
      return outcome != Outcome::Interrupted;
    });
    if (flow != GST_FLOW_OK) {
      ledger_.dropped(DropReason::Flush);
      return flow;
    }
    if (outcome == Outcome::Failed) return failed(*frames_->error());
    if (outcome == Outcome::Queued)
      ledger_.consumed();
    else
      ledger_.dropped(DropReason::Policy);
    return GST_FLOW_OK;
  }

  gboolean event(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_EOS) finish();
    if (type == GST_EVENT_FLUSH_STOP && frames_) frames_->restart();
    return parent_class()->event(self(), event);
  }

  void add_stats(GstStructure* stats) const {
    const auto c = counts();
    gst_structure_set(stats, "peers", G_TYPE_UINT64, c.peers, "messages-sent", G_TYPE_UINT64,
                      c.sent, "messages-dropped", G_TYPE_UINT64, c.dropped, "messages-lost",
                      G_TYPE_UINT64, c.lost, nullptr);
  }

  Settings settings_;

 private:
  Status open() {
    const Settings s = settings();
    max_message_ = s.max_message;
    return connect(s,
                   std::make_unique<OutgoingFrames>(OutgoingFrames::Options{
                       .queue = s.queue, .waits = s.blocking, .keeps = !s.server}),
                   net::open_sender, "sends to");
  }
  void close() {
    disconnect();
    const auto c = counts();
    GST_CAT_INFO_OBJECT(category(), self(),
                        "messages: %" G_GUINT64_FORMAT " sent, %" G_GUINT64_FORMAT
                        " dropped, %" G_GUINT64_FORMAT " lost",
                        c.sent, c.dropped, c.lost);
  }

  void finish() {
    if (!frames_ || frames_->finish(kMaxTimeToEnd)) return;
    GST_CAT_WARNING_OBJECT(category(), self(), "frames were still queued at the end of the stream");
  }

  GstFlowReturn failed(const Error& error) {
    ledger_.dropped(DropReason::Error);
    gst::post_error(element(), error);
    return GST_FLOW_ERROR;
  }

  Result<net::OutgoingMessage> encode(GstBuffer* buffer) {
    if (auto status = reader_.read(buffer, spec_); !status) return status.error();
    message_.clear();
    message_.rate_n = spec_.rate.numerator;
    message_.rate_d = spec_.rate.denominator;
    for (const auto& view : reader_.tensors()) {
      messages::MessageTensor tensor;
      tensor.type = static_cast<uint32_t>(view.spec.type);
      tensor.dimensions = view.spec.shape.dims();
      tensor.data = view.payload;
      message_.tensors.push_back(tensor);
    }
    std::shared_ptr<MessageMemory> memory;
    const auto reserve = [&](size_t bytes) {
      memory = std::make_shared<MessageMemory>(bytes);
      return memory->data();
    };
    const Status status = codec_->write(message_, reserve);
    ledger_.copied(reader_.bytes_copied());
    reader_.clear();
    if (!status) return status.error();
    if (memory->bytes().size() > max_message_) return too_large(memory->bytes().size());
    return net::OutgoingMessage{memory->bytes(), memory};
  }
  Error too_large(size_t bytes) const {
    return {.code = Code::LIMIT_EXCEEDED,
            .what = "a frame is larger than the largest message",
            .offered = std::to_string(bytes) + " bytes",
            .needed = "at most " + std::to_string(max_message_) + " bytes (max-message)",
            .fix = "max-message=" + std::to_string(bytes) + " here and at the receiver"};
  }

  gst::PlayingGate gate_;
  // Streaming thread only.
  FrameSpec spec_;
  gst::FrameLayout reader_;
  messages::TensorMessage message_;
  uint64_t max_message_ = 0;
};

}  // namespace

bool register_tensor_sink_grpc(GstPlugin* plugin) {
  return TensorSinkGrpc::register_in(plugin);
}

}  // namespace weir
