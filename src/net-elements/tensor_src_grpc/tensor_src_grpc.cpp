// tensor_src_grpc: pushes the messages of NNStreamer's TensorService as frames of tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "net-elements/grpc_element.hpp"

namespace weir {
namespace {

using gst::Ref;
using net::IncomingFrames;

struct SourceSettings : GrpcSettings {
  SourceSettings() { server = true; }
};

class TensorSrcGrpc : public GrpcElement<TensorSrcGrpc, gst::PushSource, IncomingFrames> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSrcGrpc", "tensor_src_grpc", "TensorSrcGRPC",
                                          "Source/Network",
                                          "Receives frames of tensors from other programs by gRPC"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_CAPS_GRPC)),
  };

  uint32_t out() const { return static_cast<uint32_t>(ledger_.snapshot().pushed); }

  using Settings = SourceSettings;
  static constexpr auto kProperties = std::tuple_cat(
      kGrpcProperties,
      std::tuple{gst::Property{"server", &Settings::server,
                               "true = clients connect and send frames; false = the element "
                               "connects to a server and receives them"},
                 gst::Property{
                     "blocking", &Settings::blocking,
                     "true = senders wait while the queue is full; false = drop the oldest frame"},
                 gst::ReadOnly{"out", &TensorSrcGrpc::out, "Number of frames that were pushed"},
                 gst::Property{"queue", &Settings::queue,
                               "Maximum number of messages that wait for the pipeline",
                               gst::Changeable::InReady, 1u, 65536u}});

  void constructed() {
    gst_base_src_set_live(base(), TRUE);
    gst_base_src_set_format(base(), GST_FORMAT_TIME);
  }

  Status start() {
    const Settings s = settings();
    is_server_ = s.server;
    pool_ = {};
    spec_ = {};
    return connect(s,
                   std::make_unique<IncomingFrames>(
                       IncomingFrames::Options{.queue = s.queue, .waits = s.blocking}),
                   net::open_receiver, "receives from");
  }

  gboolean stop() {
    disconnect();
    const auto c = counts();
    GST_CAT_INFO_OBJECT(category(), self(),
                        "messages: %" G_GUINT64_FORMAT " received, %" G_GUINT64_FORMAT
                        " dropped, %" G_GUINT64_FORMAT " refused",
                        c.received, c.dropped, c.refused);
    return TRUE;
  }

  // The first message has the caps; the base class would choose some before it.
  gboolean negotiate() {
    spec_ = {};
    return TRUE;
  }
  // The frames have a pool of their own.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return TRUE;
  }

  GstFlowReturn create(GstBuffer** out) {
    for (;;) {
      auto taken = frames_->take();
      switch (taken.outcome) {
        case IncomingFrames::Outcome::Interrupted:
          return GST_FLOW_FLUSHING;
        case IncomingFrames::Outcome::Ended:
          return GST_FLOW_EOS;
        case IncomingFrames::Outcome::Failed:
          gst::post_error(element(), *taken.error);
          return GST_FLOW_ERROR;
        case IncomingFrames::Outcome::Message:
          break;
      }
      ledger_.received();
      auto buffer = make_frame(taken.message);
      if (buffer) {
        ledger_.consumed_and_pushed();
        *out = buffer->release();
        return GST_FLOW_OK;
      }
      ledger_.dropped(DropReason::Error);
      if (!refuse(taken.message, buffer.error())) return GST_FLOW_ERROR;
    }
  }

  void add_stats(GstStructure* stats) const {
    const auto c = counts();
    gst_structure_set(stats, "peers", G_TYPE_UINT64, c.peers, "messages-received", G_TYPE_UINT64,
                      c.received, "messages-dropped", G_TYPE_UINT64, c.dropped, "messages-refused",
                      G_TYPE_UINT64, c.refused, nullptr);
  }

  Settings settings_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstBaseSrc* base() const { return GST_BASE_SRC(self()); }
  GstPad* pad() const { return GST_BASE_SRC_PAD(self()); }

  // A client whose messages cannot be used ends; the others go on. A server is the only peer:
  // false.
  bool refuse(const net::IncomingMessage& message, Error error) {
    error.what = "a message of " + message.peer + " was refused: " + error.what;
    if (!is_server_) {
      gst::post_error(element(), error);
      return false;
    }
    GST_CAT_WARNING_OBJECT(category(), self(), "%s", error.message().c_str());
    frames_->refuse(message, error.message());
    return true;
  }

  Result<Ref<GstBuffer>> make_frame(const net::IncomingMessage& message) {
    if (auto status = codec_->parse(whole(message.chunks), &message_); !status)
      return status.error();
    if (message_.format != messages::kStatic)
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "the message holds flexible tensors",
                   .offered = "format 1 (flexible)",
                   .needed = "format 0 (static)",
                   .fix = "other/tensors,format=static upstream of the sender"};
    if (auto status = follow(to_spec(message_)); !status) return status.error();
    auto buffer = pool_.acquire(buffer_limit_);
    if (!buffer) return buffer.error();
    gst::FramePool::Writer writer;
    if (auto status = writer.map(pool_, buffer->get()); !status) return status.error();
    for (size_t i = 0; i < message_.tensors.size(); ++i) {
      const auto& data = message_.tensors[i].data;
      std::memcpy(writer.payloads()[i].data(), data.data(), data.size());
    }
    set_times(buffer->get());
    return buffer;
  }

  // A message that arrived in several pieces is joined.
  std::span<const std::byte> whole(const net::Chunks& chunks) {
    const auto first = chunks.from(0);
    if (first.size() == chunks.size()) return first;
    joined_.resize(chunks.size());
    chunks.copy({0, chunks.size()}, joined_.data());
    ledger_.copied(joined_.size());
    return joined_;
  }

  static FrameSpec to_spec(const messages::TensorMessage& message) {
    FrameSpec out{.format = Format::Static, .tensors = {}, .rate = {0, 1}};
    if (message.has_rate()) out.rate = {message.rate_n, message.rate_d};
    for (const auto& tensor : message.tensors)
      out.tensors.push_back({.type = static_cast<ElementType>(tensor.type),
                             .shape = Shape(tensor.dimensions),
                             .name = {}});
    return out;
  }

  // Makes the caps those of the message.
  Status follow(FrameSpec spec) {
    if (spec == spec_) return ok();
    if (auto status = buffer_limit_.check(spec); !status) return status;
    const auto caps = gst::choose_caps(pad(), gst::PeerCaps(pad()), spec, false);
    if (auto status =
            gst::check_downstream(pad(), caps.get(), "a capsfilter with caps of the sender");
        !status)
      return status;
    auto pool = gst::FramePool::make(spec.tensors, Format::Static);
    if (!pool) return pool.error();
    if (!gst_base_src_set_caps(base(), caps.get()))
      return gst::downstream_mismatch(pad(), nullptr, spec.to_string(),
                                      "a downstream element that accepts these tensors");
    pool_ = *std::move(pool);
    spec_ = std::move(spec);
    return ok();
  }

  // The messages carry no times: that of the arrival is taken.
  void set_times(GstBuffer* buffer) const {
    if (const auto clock = Ref<GstClock>::adopt(gst_element_get_clock(element()))) {
      const GstClockTime now = gst_clock_get_time(clock.get());
      const GstClockTime base_time = gst_element_get_base_time(element());
      GST_BUFFER_PTS(buffer) = now > base_time ? now - base_time : 0;
    }
    if (spec_.rate.numerator > 0)
      GST_BUFFER_DURATION(buffer) =
          gst_util_uint64_scale_int(GST_SECOND, spec_.rate.denominator, spec_.rate.numerator);
  }

  // Streaming thread only.
  messages::TensorMessage message_;
  std::vector<std::byte> joined_;
  FrameSpec spec_;
  gst::FramePool pool_;
  bool is_server_ = true;
};

}  // namespace

bool register_tensor_src_grpc(GstPlugin* plugin) {
  return TensorSrcGrpc::register_in(plugin);
}

}  // namespace weir
