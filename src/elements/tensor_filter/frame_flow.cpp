// Frames on the thread that brings them, one at a time, or handed on to workers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/frame_flow.hpp"

#include <algorithm>

#include "elements/tensor_filter/deadline.hpp"
#include "gstcpp/element.hpp"
#include "gstcpp/error.hpp"

namespace weir {
namespace {

GstFlowReturn flow_of(const Error& error) {
  return error.code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
}
DropReason reason_of(GstFlowReturn flow) {
  if (flow == GST_FLOW_FLUSHING) return DropReason::Flush;
  return flow == GST_FLOW_EOS ? DropReason::Eos : DropReason::Error;
}

infer::PoolLimits limits_of(const FilterSettings& s) {
  infer::PoolLimits out{s.workers, infer::WhenBusy::Block, s.max_bytes};
  if (s.when_busy == WhenBusyChoice::DropNew) out.when_busy = infer::WhenBusy::DropNew;
  if (s.when_busy == WhenBusyChoice::DropOld) out.when_busy = infer::WhenBusy::DropOld;
  return out;
}

// The frame's model is let go before the frame is pushed: who replaces it does not wait for that.
FrameFlow::Made run_guarded(FrameInvoker& invoker, infer::ModelUse::Frame frame, GstBuffer* buffer,
                            GstClockTime deadline) {
  try {
    return invoker.run(frame, buffer, deadline);
  } catch (const std::bad_alloc&) {
    return Error{Code::OUT_OF_MEMORY, "memory ran out", "", "", "", ""};
  } catch (const std::exception& e) {
    return Error{Code::INTERNAL, e.what(), "", "", "", ""};
  }
}

}  // namespace

void FrameFlow::set_element(GstElement* element, GstPad* source) noexcept {
  element_ = element;
  queue_.set_pad(source);
}

void FrameFlow::open(const FilterSettings& settings) {
  statistics_.reset();
  report_.reset();
  pool_allocated_ = 0;
  const bool on_workers = settings.workers > 1 || settings.when_busy != WhenBusyChoice::Unset;
  const auto limits = limits_of(settings);
  waits_ = limits.when_busy == infer::WhenBusy::Block;
  drops_old_ = limits.when_busy == infer::WhenBusy::DropOld;
  // Besides those that the pool holds, results may wait for an older frame.
  queue_.set_depth(on_workers ? 2 * limits.workers + limits.ahead() : 1);
  const bool gathers = settings.batch_size > 1;
  batch_timeout_ = std::chrono::nanoseconds(gathers ? int64_t(settings.batch_timeout) : -1);
  // One batch may be gathered while another is run.
  if (gathers) queue_.set_depth(size_t{2} * settings.batch_size);
  // An engine's own thread does not wait for the elements behind.
  auto held = std::make_shared<infer::HeldBytes>(limits.bytes, limits.when_busy);
  queue_.open(gathers || settings.invoke_async, held);
  if (settings.invoke_async)
    async_.limit_silence(std::chrono::milliseconds(settings.async_timeout));
  batch_.open();
  std::lock_guard lock(workers_mutex_);
  held_ = std::move(held);
  counts_held_ = gathers || settings.invoke_async;
  if (on_workers && !counts_held_)
    workers_ = std::make_unique<infer::WorkerPool<Job>>(
        limits, [this](size_t worker, Job job) { run(worker, std::move(job)); });
}

void FrameFlow::stop() {
  flush();
  queue_.stop();
}

void FrameFlow::close() {
  queue_.close();
  async_.close();
  asynchronous_ = false;
  batch_.close();
  if (workers_) drop(workers_->flush());
  std::unique_ptr<infer::WorkerPool<Job>> ended;
  {
    std::lock_guard lock(workers_mutex_);
    ended.swap(workers_);
  }
  ended.reset();
  invokers_.reset();
}

Status FrameFlow::begin(std::shared_ptr<const OpenedModel> model, const FilterPlan& plan) {
  const auto& rate = plan.input.rate;
  frame_duration_ =
      rate.numerator > 0 ? gst_util_uint64_scale(GST_SECOND, rate.denominator, rate.numerator) : 0;
  asynchronous_ = model->is_asynchronous();
  if (asynchronous_) {
    if (auto status = async_.begin(std::move(model), plan); !status) return status;
    queue_.set_depth(async_.depth());
    return ok();
  }
  if (plan.batch) {
    batch_.begin(std::move(model), plan, batch_timeout_);
    return ok();
  }
  auto made = std::make_shared<Invokers>();
  for (size_t i = 0; i < (workers_ ? workers_->limits().workers : 1); ++i) {
    made->push_back(
        std::make_unique<FrameInvoker>(model, i, plan, &statistics_, ledger_, &pool_allocated_));
    if (i > 0)
      made->back()->prepare_beside(*made->front());
    else if (auto status = made->back()->prepare(); !status)
      return status;
  }
  invokers_ = std::move(made);
  return ok();
}

GstFlowReturn FrameFlow::take(gst::Ref<GstBuffer> buffer, GstClockTime deadline) {
  if (asynchronous_) return take_async(std::move(buffer), deadline);
  if (batch_.active()) {
    if (!is_past(element_, deadline)) return gather(std::move(buffer));
    ledger_->dropped(DropReason::Qos);
    return GST_FLOW_OK;
  }
  if (!invokers_)
    return fail({Code::NOT_NEGOTIATED, "a buffer came before caps", "", "caps", "",
                 "put a capsfilter behind the source"});
  return workers_ ? hand_on(std::move(buffer), deadline) : take_inline(std::move(buffer), deadline);
}

GstFlowReturn FrameFlow::take_inline(gst::Ref<GstBuffer> buffer, GstClockTime deadline) {
  const auto ticket = queue_.submit();
  if (!ticket) return refuse(GST_FLOW_FLUSHING);
  if (is_past(element_, deadline)) {
    drop_late(*ticket);
    return GST_FLOW_OK;
  }
  auto frame = invokers_->front()->model().begin();
  auto made = frame ? run_guarded(*invokers_->front(), *std::move(frame), buffer.get(), deadline)
                    : Made(frame.error());
  check_latency();
  if (made) {
    const GstFlowReturn flow = end(*ticket, *std::move(made));
    if (flow != GST_FLOW_OK) queue_.tell_flow();
    return flow;
  }
  if (!queue_.holds(*ticket)) return refuse(GST_FLOW_FLUSHING);  // what failed is past
  queue_.skip(*ticket);
  return fail(made.error());
}

GstFlowReturn FrameFlow::hand_on(gst::Ref<GstBuffer> buffer, GstClockTime deadline) {
  if (const auto flow = refusal(); flow != GST_FLOW_OK) return refuse(flow);
  const uint64_t bytes = gst_buffer_get_size(buffer.get());
  auto frame = invokers_->front()->model().begin();
  if (!frame) return fail(frame.error());
  const auto room = workers_->make_room(bytes);
  drop(room.dropped);
  std::optional<Ticket> ticket;
  if (room.granted) ticket = waits_ ? queue_.submit() : queue_.try_submit();
  if (!ticket && (flushing_ || waits_)) return refuse(GST_FLOW_FLUSHING);
  if (ticket)
    workers_->put({*ticket, std::move(buffer), deadline, invokers_, *std::move(frame)}, bytes);
  else
    ledger_->dropped(DropReason::Policy);
  return queue_.tell_flow();
}

GstFlowReturn FrameFlow::gather(gst::Ref<GstBuffer> buffer) {
  if (const auto flow = refusal(); flow != GST_FLOW_OK) return refuse(flow);
  infer::HeldBytes::Share share;
  using Answer = infer::HeldBytes::Answer;
  const uint64_t bytes = gst_buffer_get_size(buffer.get());
  auto answer = infer::HeldBytes::try_frame(held_, bytes, &share);
  if (answer == Answer::Full) {
    batch_.pause();  // what is held is all that there can be: a batch goes without more
    answer = infer::HeldBytes::take_frame(held_, bytes, &share);
  }
  if (answer != Answer::Taken) return give_up(answer);
  auto ticket = queue_.try_submit();
  while (!ticket && drops_old_ && !flushing_ && batch_.drop_oldest()) ticket = queue_.try_submit();
  if (!ticket && !waits_ && !flushing_) return give_up(Answer::Full);
  if (!ticket) {
    batch_.held_up();
    ticket = queue_.submit();
  }
  if (!ticket) return refuse(GST_FLOW_FLUSHING);
  batch_.add(std::move(buffer), *ticket, std::move(share));
  const auto flow = queue_.tell_flow();
  const GstFlowReturn failed = failed_;
  return failed != GST_FLOW_OK ? failed : flow;
}

bool FrameFlow::send(gst::Ref<GstEvent> event) {
  const auto type = GST_EVENT_TYPE(event.get());
  if (type == GST_EVENT_EOS || type == GST_EVENT_GAP) batch_.pause();
  return queue_.send(std::move(event));
}

GstFlowReturn FrameFlow::refuse(GstFlowReturn flow) {
  ledger_->dropped(reason_of(flow));
  return flow;
}

void FrameFlow::drop(const std::vector<Job>& jobs) {
  for (const Job& job : jobs) end(job.ticket, {});
}

void FrameFlow::run(size_t worker, Job job) noexcept {
  gst::guarded<void>(element_, [&] {
    if (is_past(element_, job.deadline)) {
      job.buffer = {};
      drop_late(job.ticket);
      return;
    }
    auto made =
        run_guarded(*(*job.invokers)[worker], std::move(job.frame), job.buffer.get(), job.deadline);
    check_latency();
    job.buffer = {};
    finish(job.ticket, std::move(made));
  });
}

void FrameFlow::drop_late(const Ticket& ticket) {
  ledger_->dropped(queue_.skip(ticket) ? DropReason::Qos : DropReason::Flush);
}

GstFlowReturn FrameFlow::end(const Ticket& ticket, gst::Ref<GstBuffer> output) {
  if (output) return queue_.finish(ticket, std::move(output));
  ledger_->dropped(queue_.holds(ticket) ? DropReason::Policy : DropReason::Flush);
  queue_.skip(ticket);
  return GST_FLOW_OK;
}

void FrameFlow::finish(const Ticket& ticket, Made made) {
  if (made) {
    end(ticket, *std::move(made));
    return;
  }
  if (!queue_.holds(ticket)) {  // flushed: nobody waits for it, and what failed is past
    ledger_->dropped(DropReason::Flush);
    return;
  }
  ledger_->dropped(DropReason::Error);
  fail_all(made.error());
  queue_.skip(ticket);  // what is behind it, an end of the stream too, leaves after its error
}

void FrameFlow::fail_all(const Error& error) {
  auto none = GST_FLOW_OK;
  if (failed_.compare_exchange_strong(none, flow_of(error))) gst::post_error(element_, error);
  held_->refuse_frames();
}

GstFlowReturn FrameFlow::refusal() const noexcept {
  if (const GstFlowReturn failed = failed_; failed != GST_FLOW_OK) return failed;
  const GstFlowReturn flow = queue_.flow();
  return flow == GST_FLOW_NOT_LINKED ? GST_FLOW_OK : flow;  // links are made while frames flow
}

void FrameFlow::drain() {
  batch_.pause();
  queue_.wait_until_empty();
  if (workers_) workers_->wait_until_idle();  // flushed frames are in work until they end
}

void FrameFlow::flush() {
  flushing_ = true;
  held_->refuse();
  std::vector<Job> waiting;
  {
    std::lock_guard lock(workers_mutex_);
    if (workers_) waiting = workers_->flush();
  }
  queue_.flush();
  batch_.flush();
  drop(waiting);
  ledger_->dropped(DropReason::Flush, async_.flush());
}

void FrameFlow::resume() {
  queue_.resume();
  async_.resume();
  failed_ = GST_FLOW_OK;
  held_->resume();
  flushing_ = false;
  std::lock_guard lock(workers_mutex_);
  if (workers_) workers_->resume();
}

FrameFlow::Delay FrameFlow::delay() const {
  if (batch_timeout_.count() >= 0) {
    const auto wait = static_cast<GstClockTime>(batch_timeout_.count());
    return {wait, wait};
  }
  std::lock_guard lock(workers_mutex_);
  if (!workers_) return {};
  const auto& limits = workers_->limits();
  const auto invoke = static_cast<GstClockTime>(std::max(0, statistics_.latency_us())) * 1000;
  const GstClockTime wait = invoke * limits.ahead() / limits.workers;
  return {wait, std::max(wait, (limits.workers + limits.ahead()) * frame_duration_)};
}

GstClockTime FrameFlow::answer_latency() noexcept {
  return report_.answer(statistics_.latency_ns().value_or(0));
}

void FrameFlow::check_latency() noexcept {
  if (!reports_) return;
  const auto average = statistics_.latency_ns();
  if (average && report_.outdated(*average))
    gst_element_post_message(element_, gst_message_new_latency(GST_OBJECT_CAST(element_)));
}

GstFlowReturn FrameFlow::fail(const Error& error) {
  ledger_->dropped(DropReason::Error);
  gst::post_error(element_, error);
  return flow_of(error);
}

void FrameFlow::add_stats(GstStructure* stats) const {
  const auto s = statistics_.snapshot();
  gst_structure_set(stats, "invokes", G_TYPE_UINT64, s.count, "last-us", G_TYPE_DOUBLE, s.last_us,
                    "average-us", G_TYPE_DOUBLE, s.average_us, "p99-us", G_TYPE_DOUBLE, s.p99_us,
                    "pool-allocated", G_TYPE_UINT64, pool_allocated_.load(), nullptr);
  infer::PoolState pool;
  {
    std::lock_guard lock(workers_mutex_);
    if (workers_)
      pool = workers_->state();
    else  // the thread that brings the frames is the worker
      pool.workers = 1, pool.busy = static_cast<size_t>(ledger_->snapshot().held());
    if (counts_held_) {
      const auto held = held_->state();
      pool.bytes_held = held.held, pool.bytes_most = held.most;
      gst_structure_set(stats, "outputs-dropped", G_TYPE_UINT64, held.dropped, nullptr);
    }
  }
  gst_structure_set(stats, "workers", G_TYPE_UINT64, uint64_t{pool.workers}, "workers-busy",
                    G_TYPE_UINT64, uint64_t{pool.busy}, "mean-busy", G_TYPE_DOUBLE, pool.mean_busy,
                    "waiting", G_TYPE_UINT64, uint64_t{pool.waiting}, "bytes-held", G_TYPE_UINT64,
                    pool.bytes_held, "bytes-most", G_TYPE_UINT64, pool.bytes_most, nullptr);
  batch_.add_stats(stats);
}

}  // namespace weir
