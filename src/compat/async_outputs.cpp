// AsyncOutputs: passes asynchronous outputs of a filter to its open frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/async_outputs.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace weir::compat {
namespace {

// Released unless the host took ownership.
struct Tensors {
  std::vector<weir_tensor> all;
  ~Tensors() {
    for (auto& tensor : all)
      if (tensor.release) tensor.release(tensor.owner);
  }
};

// Shorter than the user's limit, after which a silent filter counts as hung.
std::chrono::milliseconds within(std::chrono::milliseconds limit, std::chrono::milliseconds time) {
  if (limit.count() <= 0) return time;
  return std::max(std::min(time, limit / 2), std::chrono::milliseconds{1});
}

}  // namespace

OpenFilter::OpenFilter(std::unique_ptr<Properties> properties)
    : properties_(std::move(properties)) {}
OpenFilter::~OpenFilter() = default;

AsyncOutputs::AsyncOutputs(OpenFilter& filter, bool gives, size_t outputs,
                           std::chrono::milliseconds limit)
    : filter_(filter),
      gives_(gives),
      outputs_(outputs),
      short_limit_(within(limit, kQuietWithin)),
      long_limit_(within(limit, kQuiet)) {
  auto* prop = filter_.properties().get();
  prop->async_callback = dispatched;
  prop->async_user_data = this;
  short_watch_.emplace(TimerQueue::instance(), short_limit_, [this] { return quiet(true); });
  long_watch_.emplace(TimerQueue::instance(), long_limit_, [this] { return quiet(false); });
}

AsyncOutputs::~AsyncOutputs() {
  std::lock_guard lock(mutex_);
  end();
}

// Precondition: mutex_ is held.
void AsyncOutputs::end() {
  if (request_) request_->end();
  request_.reset();
}

// Called on the timer's thread.
bool AsyncOutputs::quiet(bool within) {
  std::lock_guard lock(mutex_);
  if (invoking_ != std::thread::id{}) return false;
  if (within == dispatches_only_within()) end();
  return true;
}

void AsyncOutputs::begin(Request& request) {
  std::lock_guard lock(mutex_);
  if (too_late_) throw Failure(*std::exchange(too_late_, std::nullopt));
  end();
  request_.emplace(std::move(request));
  invoking_ = std::this_thread::get_id();
}

void AsyncOutputs::invoked() {
  {
    std::lock_guard lock(mutex_);
    invoking_ = {};
  }
  short_watch_->touch();
  long_watch_->touch();
}

void AsyncOutputs::failed(const Error& error) {
  std::lock_guard lock(mutex_);
  invoking_ = {};
  if (request_) request_->fail(error);
  request_.reset();
}

int AsyncOutputs::dispatched(GstTensorMemory* output, GstTensorsInfo*, void* self) {
  auto& async_outputs = *static_cast<AsyncOutputs*>(self);
  std::lock_guard lock(async_outputs.mutex_);
  std::optional<Error> failure;
  try {
    async_outputs.dispatch(output);
  } catch (const Failure& e) {
    failure = e.error();
  } catch (const std::exception& e) {
    failure =
        Error{.code = Code::OUT_OF_MEMORY, .what = "no memory for an output", .offered = e.what()};
  }
  if (!failure) return 0;
  if (async_outputs.request_)
    async_outputs.request_->fail(*failure);
  else
    nns_loge("%s", failure->message().c_str());
  async_outputs.request_.reset();
  return -EINVAL;
}

// Precondition: mutex_ is held.
void AsyncOutputs::dispatch(GstTensorMemory* output) {
  auto& properties = filter_.properties();
  const Described now = described(properties.get()->output_meta, filter_.name(), "output");
  if (properties.dynamic()) properties.forget_output_names();
  const auto filter = filter_.weak_from_this().lock();
  const auto limit = dispatches_only_within() ? short_limit_ : long_limit_;
  (invoking_ == std::this_thread::get_id() ? dispatched_within_ : dispatched_later_) = true;
  short_watch_->touch();
  long_watch_->touch();
  if (request_ && filter) return give_on(output, now, filter);
  for (size_t i = 0; gives_ && i < now.infos.size(); ++i) destroy(filter_, &output[i]);
  if (!filter)
    return nns_logw(
        "the filter %s returned an output while it was being closed; the output is dropped",
        filter_.name().c_str());
  too_late_ = Error{
      .code = Code::CALLBACK_FAILED,
      .what = "the filter " + filter_.name() + " returned an output after its frame had ended",
      .offered = std::to_string(now.infos.size()) + " tensors, when no frame was in progress",
      .needed = "an output within " + std::to_string(limit.count()) +
                " ms of the previous one, or of the start of the frame",
      .fix = "return from invoke only after the last output of the frame was dispatched"};
  nns_loge("%s", too_late_->message().c_str());
}

// Precondition: mutex_ is held.
void AsyncOutputs::give_on(GstTensorMemory* output, const Described& now,
                           const std::shared_ptr<OpenFilter>& filter) {
  const size_t count = now.infos.size();
  const bool dynamic = filter_.properties().dynamic();
  if (dynamic && count > outputs_) throw too_many(filter_.name(), count, outputs_);
  Tensors tensors{std::vector<weir_tensor>(dynamic ? outputs_ : count)};
  for (size_t i = count; i < tensors.all.size(); ++i) leave_out(&tensors.all[i]);
  for (size_t i = 0; i < count; ++i) {
    weir_tensor_info info = now.infos[i];
    info.name = nullptr;
    if (!output[i].data || output[i].size != count_bytes(info))
      throw other_size(filter_.name(), i, output[i], info);
    if (gives_) {
      give(filter, &output[i], info, &tensors.all[i]);
    } else {
      allocate(&tensors.all[i], info, output[i].size);
      std::memcpy(tensors.all[i].data, output[i].data, output[i].size);
    }
  }
  request_->output(tensors.all);
  tensors.all.clear();
}

}  // namespace weir::compat
