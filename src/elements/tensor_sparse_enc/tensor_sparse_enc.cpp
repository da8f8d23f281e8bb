// tensor_sparse_enc: converts dense tensors to sparse ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/packed_tensors.hpp"
#include "elements/tensor_sparse_enc/sparse_filter.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

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

  Status take_caps(GstCaps* caps) {
    if (auto status = read_caps(caps); !status) return status;
    FrameSpec sparse;
    sparse.format = Format::Sparse;
    sparse.rate = input_.rate;
    return gst::send_caps(source_, sparse, output_caps(sparse).get());
  }

  void drop_held(DropReason) {}
  void forget() { input_ = {}; }
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
    const size_t count = headers_.size();
    const size_t alone = count > kMemoryLimit ? kMemoryLimit - 1 : count;
    for (size_t i = 0; i < alone; ++i)
      if (auto status = append(out.get(), i, i + 1); !status) return status.error();
    if (alone < count)
      if (auto status = append(out.get(), alone, count); !status) return status.error();
    return out;
  }

 private:
  // The caps that the peer fixes, at any rate (docs/compatibility/routing.md 6.11); else the
  // input's rate.
  Ref<GstCaps> output_caps(const FrameSpec& sparse) const {
    if (auto fixed = fixed_downstream_caps()) return fixed;
    return gst::possible_caps(source_, sparse, nullptr);
  }

  // Appends one memory with the chunks of these tensors; several follow a packed header.
  Status append(GstBuffer* out, size_t begin, size_t end) {
    const size_t packed = end - begin > 1 ? kPackedHeaderBytes : 0;
    std::vector<uint64_t> sizes;
    size_t total = packed;
    for (size_t i = begin; i < end; ++i) {
      sizes.push_back(kTensorHeaderBytes + *headers_[i].payload_bytes());
      total += sizes.back();
    }
    auto memory = gst::allocate_memory(total);
    if (!memory) return memory.error();
    const gst::MappedMemory map(memory->get(), GST_MAP_WRITE);
    if (!map) return gst::memory_ran_out(total);
    gst_buffer_append_memory(out, memory->release());
    if (packed) {
      const auto first = input_.tensors.begin() + static_cast<std::ptrdiff_t>(begin);
      const std::vector<TensorSpec> specs(first, input_.tensors.end());
      write_packed_header(specs, sizes, map.bytes().first<kPackedHeaderBytes>());
    }
    size_t offset = packed;
    for (size_t i = begin; i < end; ++i) {
      const size_t size = sizes[i - begin];
      write_sparse(headers_[i], reader_.tensors()[i].payload, map.bytes().subspan(offset, size));
      offset += size;
    }
    return ok();
  }
};

}  // namespace

bool register_tensor_sparse_enc(GstPlugin* plugin) {
  return TensorSparseEnc::register_in(plugin);
}

}  // namespace weir
