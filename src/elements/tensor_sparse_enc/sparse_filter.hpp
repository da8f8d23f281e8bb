// SparseFilter: the common part of tensor_sparse_enc and tensor_sparse_dec. Impl has
//   bool ready() const                         caps have arrived and frames can be read
//   Result<gst::Ref<GstBuffer>> convert(GstBuffer*)   the output for a received frame
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/tensor/sparse.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/plain_filter.hpp"

namespace weir {

#define WEIR_CAPS_DENSE \
  "other/tensors, format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE

template <class Impl>
class SparseFilter : public gst::PlainFilter<Impl> {
 public:
  struct Settings {
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
  };

  GstFlowReturn chain(gst::Ref<GstBuffer> in) {
    auto* impl = static_cast<Impl*>(this);
    if (!impl->ready()) return this->failed(gst::buffer_before_caps());
    auto out = impl->convert(in.get());
    this->ledger_.copied(reader_.bytes_copied());
    reader_.clear();
    if (!out) return this->failed(out.error());
    this->ledger_.consumed_and_pushed();
    return gst_pad_push(this->source_, out->release());
  }

  Settings settings_;

 protected:
  // The caps that the peer fixes; null when it allows more than one.
  gst::Ref<GstCaps> fixed_downstream_caps() const {
    const auto own = gst::Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(this->source_));
    auto peer = gst::Ref<GstCaps>::adopt(gst_pad_peer_query_caps(this->source_, own.get()));
    return gst_caps_is_fixed(peer.get()) ? peer : gst::Ref<GstCaps>();
  }
  Status read_caps(GstCaps* caps) {
    auto spec = gst::fixed_spec_from_caps(caps);
    if (!spec) return spec.error();
    input_ = *std::move(spec);
    return ok();
  }

  // Streaming thread only:
  FrameSpec input_;
  gst::FrameLayout reader_;
  std::vector<TensorHeader> headers_;  // of the current frame
};

}  // namespace weir
