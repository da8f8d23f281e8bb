// tensor_sparse_enc: converts dense tensors to sparse ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_sparse_enc/sparse_filter.hpp"
#include "gstcpp/buffer/frame_builder.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorSparseEnc : public SparseFilter<TensorSparseEnc> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorSparseEnc", "tensor_sparse_enc",
                                          "TensorSparseEnc", "Filter/Tensor",
                                          "Converts dense tensors to sparse tensors"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("sparse"))),
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_DENSE)),
  };

  Status set_caps(GstCaps* caps) {
    if (auto status = read_caps(caps); !status) return status;
    FrameSpec sparse;
    sparse.format = Format::Sparse;
    sparse.rate = input_.rate;
    return gst::send_caps(source_, sparse, output_caps(sparse).get());
  }

  void drain(DropReason) {}
  void reset() { input_ = {}; }
  bool ready() const { return !input_.tensors.empty(); }

  Result<Ref<GstBuffer>> convert(GstBuffer* in) {
    if (auto status = reader_.read(in, input_); !status) return status.error();
    headers_.clear();
    for (const auto& view : reader_.tensors()) {
      auto header = sparse_header(view.spec, view.payload);
      if (!header) return header.error();
      headers_.push_back(*std::move(header));
    }
    auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
    gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
    sizes_.clear();
    for (const auto& header : headers_)
      sizes_.push_back(kTensorHeaderBytes + *header.payload_bytes());
    const auto status = gst::append_filled(
        input_.tensors, sizes_, out.get(), [this](size_t n, std::span<std::byte> bytes) -> Status {
          write_sparse(headers_[n], reader_.tensors()[n].payload, bytes);
          return ok();
        });
    if (!status) return status.error();
    return out;
  }

 private:
  // The caps that the peer fixes, at any rate (docs/compatibility/routing.md 6.11); else the
  // input's rate.
  Ref<GstCaps> output_caps(const FrameSpec& sparse) const {
    if (auto fixed = fixed_downstream_caps()) return fixed;
    return gst::possible_caps(source_, sparse, nullptr);
  }

  std::vector<uint64_t> sizes_;  // of the sparse tensors, with their headers
};

}  // namespace

bool register_tensor_sparse_enc(GstPlugin* plugin) {
  return TensorSparseEnc::register_in(plugin);
}

}  // namespace weir
