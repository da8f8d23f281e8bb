// FilterModel: runs frames through a filter's callbacks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/filter_model.hpp"

#include <algorithm>
#include <cstring>

#include "compat/async_outputs.hpp"

namespace weir::compat {
namespace {

bool same(const weir_tensor_info& a, const weir_tensor_info& b) {
  return a.type == b.type && a.rank == b.rank && a.rank <= WEIR_RANK_LIMIT &&
         std::equal(a.shape, a.shape + a.rank, b.shape);
}

// Maximum number of outputs of a filter that reports their number only with each frame.
constexpr size_t kMaxUnsaid = 16;

}  // namespace

FilterModel::FilterModel(std::shared_ptr<OpenFilter> filter)
    : filter_(std::move(filter)),
      dynamic_(filter_->properties().dynamic()),
      allocates_(filter_->allocates()) {
  OwnedTensorsInfo in, out;
  const auto known = filter_->get_info(in.get(), out.get());
  if (known.inputs && (*in).format == _NNS_TENSOR_FORMAT_STATIC) {
    inputs_ = described(*in, filter_->name(), "input");
    filter_->properties().configure_inputs(inputs_.infos);
  } else if (known.inputs && (*in).num_tensors <= WEIR_TENSOR_LIMIT) {
    inputs_ = open_tensors((*in).num_tensors);  // only the number: each frame has its own sizes
  }
  if (known.outputs && !dynamic_ && (*out).format == _NNS_TENSOR_FORMAT_STATIC) {
    outputs_ = described(*out, filter_->name(), "output");
    filter_->properties().configure_outputs(outputs_.infos);
  }
  if (dynamic_) {
    const size_t static_count = known.outputs ? (*out).num_tensors : 0;
    const size_t declared = std::max(static_count, filter_->properties().declared_outputs());
    outputs_ = open_tensors(declared > 0 && declared <= WEIR_TENSOR_LIMIT ? declared : kMaxUnsaid);
  }
  if (filter_->properties().asynchronous())
    filter_->async_outputs =
        std::make_unique<AsyncOutputs>(*filter_, allocates_ || dynamic_, outputs_.infos.size(),
                                       filter_->properties().async_timeout());
}

void FilterModel::describe(weir_model_info& info) const {
  if (!filter_->properties().asynchronous())
    info.flags &= ~(uint32_t{WEIR_MODEL_ASYNC} | WEIR_MODEL_CANCELS);
  else
    info.max_in_flight = 2;  // a frame stays open until the next one begins
  if (dynamic_) info.flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
  if (allocates_) info.flags |= WEIR_MODEL_ALLOCATES_OUTPUT;
}

// Gets the outputs for these inputs; queries the filter only when the inputs changed.
void FilterModel::describe_outputs(std::span<const weir_tensor_info> in) {
  const bool known =
      stream_.size() == in.size() && std::equal(in.begin(), in.end(), stream_.begin(), same);
  if (known) return;
  auto& properties = filter_->properties();
  properties.configure_inputs(in);
  stream_.assign(in.begin(), in.end());
  for (auto& info : stream_) info.name = nullptr;
  if (dynamic_) return;
  if (!outputs_.infos.empty()) {
    properties.configure_outputs(outputs_.infos);
    return;
  }
  OwnedTensorsInfo offered, out;
  offered.assign(in);
  const int result = filter_->set_inputs(offered.get(), out.get());
  if (result < 0) {
    stream_.clear();
    throw broke(filter_->name(),
                result == -ENOENT ? "neither declares its tensors nor accepts those of the stream"
                                  : "rejects the inputs of the stream",
                "the return value " + returned(result), "0 or above",
                result == -ENOENT
                    ? "tensor_filter input=... inputtype=... output=... outputtype=..."
                    : "other/tensors caps with dimensions and types that the filter accepts");
  }
  resolved_outputs_ = described(*out, filter_->name(), "output");
  properties.configure_outputs(resolved_outputs_.infos);
}

void FilterModel::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  const bool open = std::any_of(in.begin(), in.end(), [](const auto& info) {
    return info.type >= WEIR_TYPE_END || info.rank > WEIR_RANK_LIMIT ||
           std::any_of(info.shape, info.shape + info.rank, [](int64_t n) { return n <= 0; });
  });
  if (open) return;  // the filter needs complete inputs
  describe_outputs(in);
  if (dynamic_ || !outputs_.infos.empty()) return;
  if (resolved_outputs_.infos.size() > out.size())
    throw broke(filter_->name(), "has a different number of outputs than before",
                std::to_string(resolved_outputs_.infos.size()), std::to_string(out.size()),
                "return the same number of outputs for all inputs");
  std::copy(resolved_outputs_.infos.begin(), resolved_outputs_.infos.end(), out.begin());
}

void FilterModel::point_to(const weir_frame& in) {
  in_.resize(in.n_tensors);
  for (uint32_t i = 0; i < in.n_tensors; ++i) {
    in_[i].data = in.tensors[i].data;
    in_[i].size = static_cast<size_t>(in.tensors[i].bytes);
  }
}

// In a stream of flexible tensors, sizes change from frame to frame.
void FilterModel::follow(const weir_frame& in) {
  point_to(in);
  const auto is_known = [&](uint32_t i) { return same(in.tensors[i].info, stream_[i]); };
  bool known = stream_.size() == in.n_tensors;
  for (uint32_t i = 0; known && i < in.n_tensors; ++i) known = is_known(i);
  if (known) return;
  std::vector<weir_tensor_info> now;
  for (uint32_t i = 0; i < in.n_tensors; ++i) now.push_back(in.tensors[i].info);
  describe_outputs(now);
}

int FilterModel::run() {
  const int result = filter_->invoke(in_.data(), out_.data());
  if (result >= 0) return result;
  throw Failure({.code = Code::INVOKE_FAILED,
                 .what = "the filter " + filter_->name() + " failed on a frame",
                 .offered = "the return value " + returned(result),
                 .needed = "0 for success, or above 0 to drop the frame",
                 .fix = "set GST_DEBUG=weir*:5 to see the log messages of the filter"});
}

void FilterModel::drop_outputs() noexcept {
  for (auto& memory : out_) destroy(*filter_, &memory);
}

// Uses outputs that the filter allocated with the negotiated sizes.
void FilterModel::fill_given(weir_frame& out) {
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    const uint64_t wanted = count_bytes(out.tensors[i].info);
    if (!out_[i].data)
      throw broke(filter_->name(), "must allocate its outputs, but returned no memory",
                  which(i, out_[i]), std::to_string(wanted) + " bytes",
                  "output[" + std::to_string(i) + "].data = malloc(output[" + std::to_string(i) +
                      "].size)");
    if (out_[i].size != wanted)
      throw broke(filter_->name(), "returned an output of a different size", which(i, out_[i]),
                  std::to_string(wanted) + " bytes: " + weir::describe(out.tensors[i].info),
                  "do not change output[].size, or set invoke-dynamic=true");
  }
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    if (void* place = out.tensors[i].data)
      std::memcpy(place, out_[i].data, out_[i].size);  // a batch, or another process
    else
      give(filter_, &out_[i], out.tensors[i].info, &out.tensors[i]);
  }
}

// Uses outputs whose sizes the filter chose.
void FilterModel::fill_dynamic(weir_frame& out) {
  auto& properties = filter_->properties();
  const Described now = described(properties.get()->output_meta, filter_->name(), "output");
  const size_t count = now.infos.size();
  if (count > out.n_tensors) throw too_many(filter_->name(), count, out.n_tensors);
  for (size_t i = 0; i < count; ++i)
    if (!out_[i].data || out_[i].size != count_bytes(now.infos[i]))
      throw other_size(filter_->name(), i, out_[i], now.infos[i]);
  for (size_t i = 0; i < count; ++i) give(filter_, &out_[i], now.infos[i], &out.tensors[i]);
  for (size_t i = count; i < out.n_tensors; ++i) leave_out(&out.tensors[i]);
}

bool FilterModel::invoke(const weir_frame& in, weir_frame& out) {
  follow(in);
  return allocates_ || dynamic_ ? invoke_allocating(out) : invoke_in_place(out);
}

// The filter writes into the memory of `out`.
bool FilterModel::invoke_in_place(weir_frame& out) {
  out_.assign(out.n_tensors, {});
  for (uint32_t i = 0; i < out.n_tensors; ++i) {
    auto& tensor = out.tensors[i];
    if (!tensor.data) allocate(&tensor, tensor.info, count_bytes(tensor.info));
    out_[i].data = tensor.data;
    out_[i].size = static_cast<size_t>(tensor.bytes);
  }
  if (run() > 0) return false;
  for (uint32_t i = 0; i < out.n_tensors; ++i)
    if (out_[i].data != out.tensors[i].data || out_[i].size != out.tensors[i].bytes)
      throw broke(
          filter_->name(), "changed the address or size of its output", which(i, out_[i]),
          std::to_string(out.tensors[i].bytes) + " bytes, written to the memory in output[].data",
          "to return other memory, set allocate_invoke, or allocate_in_invoke to 1");
  return true;
}

// The filter allocates its outputs.
bool FilterModel::invoke_allocating(weir_frame& out) {
  out_.assign(std::max<size_t>(out.n_tensors, WEIR_TENSOR_LIMIT), {});
  for (uint32_t i = 0; !dynamic_ && i < out.n_tensors; ++i)
    out_[i].size = static_cast<size_t>(count_bytes(out.tensors[i].info));
  struct Rest {
    FilterModel* model;
    ~Rest() {
      model->drop_outputs();
      if (model->dynamic_) model->filter_->properties().forget_output_names();
    }
  } const rest{this};
  if (run() > 0) return false;
  if (dynamic_)
    fill_dynamic(out);
  else
    fill_given(out);
  return true;
}

void FilterModel::submit(const weir_frame& in, Request& request) {
  follow(in);
  out_.assign(WEIR_TENSOR_LIMIT, {});
  auto& async_outputs = *filter_->async_outputs;
  async_outputs.begin(request);
  try {
    run();
  } catch (const Failure& failure) {
    return async_outputs.failed(failure.error());
  }
  async_outputs.invoked();
}

void FilterModel::control(int op, const weir_option*) {
  if (op == WEIR_WARM || op == WEIR_RESET_STATE) return;  // only frames invoke the filter
  const bool suspend = op == WEIR_SUSPEND;
  if (!suspend && op != WEIR_RESUME)
    throw Failure({.code = Code::MODEL_UNSUPPORTED,
                   .what = "filters of NNStreamer have no such event",
                   .offered = "event " + std::to_string(op),
                   .needed = "SUSPEND or RESUME"});
  const int result = filter_->send(suspend ? SUSPEND : RESUME);
  if (result < 0)
    throw Failure({.code = Code::MODEL_UNSUPPORTED,
                   .what = "the filter " + filter_->name() + " does not handle this event",
                   .offered = std::string("the return value for ") +
                              (suspend ? "SUSPEND" : "RESUME") + ": " + returned(result),
                   .needed = "0 or above"});
}

}  // namespace weir::compat
