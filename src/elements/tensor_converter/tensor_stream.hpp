// TensorStream: the stream of tensors that tensor_converter makes of the caps of its input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "elements/tensor_converter/client_streams.hpp"
#include "elements/tensor_converter/converter_settings.hpp"
#include "elements/tensor_converter/media.hpp"
#include "elements/tensor_converter/tensor_memories.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {

// The medium of the input, the plan of the output and the caps that were sent. All three change
// together: when caps arrive, when properties change, and when a frame defines other tensors.
// Streaming thread only, except bytes_gathered().
class TensorStream {
 public:
  // The arguments belong to the element. `waiting` has the frames that do not fill a tensor yet:
  // they are dropped when the tensors change.
  TensorStream(Ledger* ledger, const BufferLimit* limit, ClientStreams* waiting)
      : ledger_(*ledger), limit_(*limit), waiting_(*waiting) {}
  void send_to(GstPad* source) { source_ = source; }

  // Makes the stream that of `caps`. `goes_on`: a running stream whose frames carry their specs
  // no longer needs a placeholder. `next`, which may be null, is the frame that has to fit. After
  // an error there is no stream.
  Status configure(const GstCaps* caps, const ConverterSettings& settings,
                   const ConverterMode& mode, bool goes_on, const GstBuffer* next);
  bool is_configured() const noexcept { return medium_ != nullptr; }
  const StreamPlan& plan() const noexcept { return plan_; }
  void close() { medium_.reset(); }  // until configure() there is no stream
  void reset();                      // as before the first caps
  void flush();                      // drops what the medium keeps, and the segment

  // Converts a buffer to whole frames, and sends other caps if they define other tensors.
  Result<MediumFrames> convert(gst::Ref<GstBuffer> buffer);
  // Makes the output of the frames that fill it.
  Result<gst::Ref<GstBuffer>> make_output(gst::Ref<GstBuffer> frames);

  // Caps are sent when the first frame defines them; until then, segments are held.
  bool waits_for_frame() const noexcept { return waits_for_frame_; }
  gboolean send_segment(gst::Ref<GstEvent> segment);
  void offer(GstQuery* query) const;  // answers an ALLOCATION query; call configure() first

  uint64_t bytes_gathered() const noexcept { return counts_->bytes_gathered; }
  void reset_counts() noexcept { counts_->bytes_gathered = 0; }

 private:
  Status take(StreamPlan plan, const gst::PeerCaps& peer, MediaType type, bool goes_on);
  Status announce(const gst::PeerCaps& peer);
  void drop_waiting();

  Ledger& ledger_;
  const BufferLimit& limit_;
  ClientStreams& waiting_;
  GstPad* source_ = nullptr;        // owned by the element
  std::unique_ptr<Medium> medium_;  // null until caps are accepted
  StreamPlan plan_;
  gst::Allocation allocation_;  // requested by the peer
  bool deferral_ = false;       // the peer accepts deferred memory
  const std::shared_ptr<gst::DeferredCounts> counts_ = std::make_shared<gst::DeferredCounts>();
  Format planned_format_ = Format::Static;  // of frames that do not define it themselves
  Format output_format_ = Format::Static;   // of the caps that were sent
  bool has_headers_ = false;                // the current frame's memories begin with headers
  HeaderedFrames headered_;
  bool waits_for_frame_ = false;
  gst::Ref<GstEvent> held_segment_;  // sent after the caps
};

}  // namespace weir
