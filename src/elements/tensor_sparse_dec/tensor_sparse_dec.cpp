// tensor_sparse_dec: converts sparse tensors to dense ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_sparse_enc/sparse_filter.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/pads/early_events.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorSparseDec : public SparseFilter<TensorSparseDec> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSparseDec", "tensor_sparse_dec",
                                          "TensorSparseDec", "Filter/Tensor",
                                          "Converts sparse tensors to dense tensors"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(WEIR_CAPS_DENSE)),
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("sparse"))),
  };

  // The peer may fix the tensors; otherwise the first frame defines them.
  Status set_caps(GstCaps* caps) {
    if (auto status = read_caps(caps); !status) return status;
    pool_ = {};
    const auto peer = fixed_downstream_caps();
    fixed_ = static_cast<bool>(peer);
    if (!fixed_) return ok();
    auto fixed = gst::fixed_spec_from_caps(peer.get());
    if (!fixed) return fixed.error();
    return announce(fixed->tensors, peer.get());
  }

  bool ready() const { return input_.format == Format::Sparse; }

  Result<Ref<GstBuffer>> convert(GstBuffer* in) {
    if (auto status = reader_.read(in, input_); !status) return status.error();
    headers_.clear();
    chunks_.clear();
    std::vector<TensorSpec> tensors;
    for (const auto& view : reader_.tensors()) {
      chunks_.push_back(
          {view.payload.data() - kTensorHeaderBytes, view.payload.size() + kTensorHeaderBytes});
      auto header = read_sparse_header(chunks_.back());
      if (!header) return header.error();
      tensors.push_back(header->spec);
      headers_.push_back(*std::move(header));
    }
    if (auto status = settle(std::move(tensors)); !status) return status.error();
    auto out = pool_.acquire(buffer_limit_);
    if (!out) return out;
    auto status = writer_.map(pool_, out->get());
    for (size_t i = 0; status && i < headers_.size(); ++i)
      status = read_sparse(headers_[i], chunks_[i], writer_.payloads()[i]);
    writer_.unmap();
    if (!status) return status.error();
    gst_buffer_copy_into(out->get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    return out;
  }

  // Serialized events wait until caps are sent.
  bool sink_event(GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    if (type == GST_EVENT_FLUSH_STOP) early_.clear();
    if (type == GST_EVENT_EOS) early_.send(source_);
    const bool serialized = gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED;
    // Others come on any thread.
    if (!serialized || pool_ || type <= GST_EVENT_CAPS || type == GST_EVENT_FLUSH_STOP ||
        type == GST_EVENT_EOS)
      return false;
    early_.push(Ref<GstEvent>::adopt(event));
    return true;
  }

  void drain(DropReason reason) {
    if (reason != DropReason::Eos) early_.clear();
  }

  void reset() {
    input_ = {};
    pool_ = {};
    allocation_ = {};
  }

  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  // Sends caps for these tensors, `given` or by docs/compatibility/types-and-caps.md 1.5, and makes
  // their pool.
  Status announce(const std::vector<TensorSpec>& tensors, GstCaps* given) {
    FrameSpec spec{Format::Static, tensors, input_.rate};
    if (auto status = buffer_limit_.check(spec); !status) return status;
    auto caps = given ? Ref<GstCaps>::share(given)
                      : gst::choose_caps(source_, gst::PeerCaps(source_), spec);
    auto pool = gst::FramePool::make(tensors, Format::Static);
    if (!pool) return pool.error();
    if (auto status = gst::send_caps(source_, spec, caps.get()); !status) return status;
    allocation_ = gst::wanted_by_peer(source_, caps.get(), ledger_, allocation_);
    if (!(allocation_ == gst::Allocation{}))
      pool = gst::FramePool::make(tensors, Format::Static, MediaType::Tensor, allocation_);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    early_.send(source_);
    return ok();
  }

  // Announces the tensors of this frame if they changed.
  Status settle(std::vector<TensorSpec> tensors) {
    const std::string difference =
        pool_ ? first_difference(tensors, pool_.tensors()) : std::string("no caps yet");
    if (difference.empty()) return ok();
    if (!fixed_) return announce(tensors, nullptr);
    FrameSpec came{Format::Static, std::move(tensors), input_.rate}, needed = came;
    needed.tensors = pool_.tensors();
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what =
            "the tensors of a sparse frame do not match the caps downstream of tensor_sparse_dec",
        .offered = came.to_string(),
        .needed = needed.to_string(),
        .difference = difference,
        .fix = gst::caps_to_paste(came)};
  }

  // Streaming thread only:
  bool fixed_ = false;          // the peer fixed the tensors
  gst::EarlyEvents early_;      // until there are caps to send
  gst::Allocation allocation_;  // requested by the peer
  gst::FramePool pool_;         // for the announced tensors; none before
  gst::FramePool::Writer writer_;
  std::vector<std::span<const std::byte>> chunks_;  // of the current frame
};

}  // namespace

bool register_tensor_sparse_dec(GstPlugin* plugin) {
  return TensorSparseDec::register_in(plugin);
}

}  // namespace weir
