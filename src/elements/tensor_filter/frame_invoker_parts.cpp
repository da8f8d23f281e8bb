// The parts of a run for frames whose outputs come later, and outputs of another size than was
// told.
#include "elements/tensor_filter/frame_invoker.hpp"
#include "elements/tensor_filter/output_size.hpp"

namespace weir {

void FrameInvoker::use(const infer::ModelUse::Frame& frame) noexcept {
  frame_ = &frame;
  plan_.alignment = frame.model().info().alignment;
  plan_.padding = frame.model().info().input_padding;
}

Status FrameInvoker::open(const infer::ModelUse::Frame& frame, GstBuffer* in,
                          GstClockTime deadline) {
  use(frame);
  const Status status = read(in, deadline);
  frame_ = nullptr;
  return status;
}

Status FrameInvoker::read(GstBuffer* in, GstClockTime deadline) {
  if (auto status = begin(in); !status) return status.error();
  if (!plan_.has_memory()) outputs_ = described_;  // what the engine said of the frame before
  describe_frame(in, deadline);
  return ok();
}

Result<gst::Ref<GstBuffer>> FrameInvoker::collect(GstBuffer* in, weir_frame& given) {
  if (given.n_tensors != outputs_.size() || (given.n_tensors > 0 && !given.tensors))
    return Error{Code::INVOKE_FAILED,
                 "the engine gave another number of outputs than the model has",
                 std::to_string(given.tensors ? given.n_tensors : 0),
                 std::to_string(outputs_.size()),
                 "number of tensors",
                 ""};
  auto made = assemble(in, {}, {given.tensors, given.n_tensors});
  if (made) copy_metas(in, made->get());
  return made;
}

Status FrameInvoker::check_given_memory() const {
  for (size_t i = 0; i < outputs_.size(); ++i) {
    const weir_tensor& tensor = outputs_[i];
    const bool same = tensor.data == writer_.payloads()[i].data() &&
                      tensor.bytes == writer_.payloads()[i].size() &&
                      same_shape(tensor.info, described_[i].info);
    if (!same) return changed_size(i, tensor.info, plan_.model_outputs[i]);
  }
  return ok();
}

}  // namespace weir
