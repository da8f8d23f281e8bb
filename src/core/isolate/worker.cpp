// The lifecycle of a worker, and the calls without tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/worker.hpp"

#include <algorithm>

#include "core/isolate/isolation.hpp"

namespace weir::isolate {
namespace {

using namespace std::chrono_literals;

constexpr auto kToClose = 2s, kToExit = 1s;
constexpr int kOnce = 10;  // times the time-out of an invoke

}  // namespace

Result<std::unique_ptr<Worker>> Worker::start(const WorkerSettings& settings, int cancel) {
  std::unique_ptr<Worker> worker(new Worker(settings));
  auto process = WorkerProcess::start(settings.memory_mib);
  if (!process) return process.error();
  worker->process_ = *std::move(process);
  if (auto status = worker->open(cancel); !status) {
    worker->alive_ = false;
    return status.error();
  }
  return worker;
}

Status Worker::open(int cancel) {
  channel_ = Channel(process_->take_socket(), process_->descriptor(), settings_.stop, cancel);
  auto until = deadline(kOnce);
  const auto min = io::deadline_in(settings_.min_for_start);
  if (until && (!min || *min > *until)) {
    until = min;
    limit_ = settings_.min_for_start;
  }
  const auto passage = channel_.receive(until, &response_);
  if (passage == Passage::Cancelled) return lost(passage, "at its start");
  MessageReader hello(response_.body);
  const auto protocol = hello.take<uint32_t>();
  confinement_.text = hello.text();
  confinement_.refused = hello.text();
  if (passage != Passage::Done || response_.kind != Kind::Hello || !hello.complete() ||
      protocol != kProtocol) {
    const auto end = process_->wait(passage == Passage::Ended ? kToExit : 0s);
    return Error{.code = Code::WORKER_NOT_STARTED,
                 .what = "the worker program is not the weir-worker of this version",
                 .offered = WorkerProcess::program() + (end ? ": " + *end : ""),
                 .needed = "weir-worker of the same installation",
                 .fix = worker_fix()};
  }
  writer_.begin(Kind::Open);
  settings_.open.put(&writer_);
  if (auto status = ask(Kind::Opened, until, "while it opened the model"); !status)
    return alive_ ? status : Status(about_model(status.error()));
  MessageReader opened(response_.body);
  facts_ = std::make_shared<const WorkerModelInfo>(WorkerModelInfo::take(&opened));
  if (!opened.complete())
    return invalid_message("while it opened the model", "an incomplete model description");
  channel_.set_cancel(-1);
  return ok();
}

// Before the first frame has succeeded, the fix is another model or engine, not other settings.
Error Worker::about_model(Error error) const {
  if (error.code != Code::WORKER_ENDED) return error;
  const OpenCall& call = settings_.open;
  std::string model;
  for (const auto& path : call.paths) model += (model.empty() ? " model=" : ",") + path;
  if (!call.engine.empty()) model = " framework=" + call.engine + model;
  if (!model.empty()) error.offered += " of" + model;
  error.fix = "another model file, or another framework";
  return error;
}

Worker::~Worker() {
  channel_ = {};  // the worker reads EOF from the socket and exits
  if (alive_ && process_) process_->wait(kToClose);
}

io::Deadline Worker::deadline(int times) {
  limit_ = settings_.timeout * times;
  if (settings_.timeout.count() <= 0) return std::nullopt;
  return io::deadline_in(settings_.timeout, times);
}

std::string Worker::on_frame() const {
  return "on invoke " + std::to_string(invokes_) + " of this process";
}

bool Worker::ended_idle() {
  if (alive_ && process_->wait(0ms)) alive_ = false;
  return !alive_;
}

Error Worker::idle_end() {
  return lost(Passage::Ended, "between two frames");
}

Error Worker::lost(Passage passage, const std::string& doing) {
  alive_ = false;
  if (passage == Passage::TimedOut) {
    process_->kill();
    const bool has_longer = limit_ > settings_.timeout;  // some calls have several times as long
    const auto own = std::to_string(settings_.timeout.count());
    return Error{.code = Code::WORKER_TIMEOUT,
                 .what = "the model timed out " + doing,
                 .offered = has_longer ? "nothing within " + std::to_string(limit_.count()) +
                                             " ms, with isolate-timeout=" + own + " ms"
                                       : "isolate-timeout=" + own + " ms",
                 .needed = "a reply",
                 .fix = "isolate-timeout=" +
                        std::to_string(std::max(10 * settings_.timeout, limit_).count())};
  }
  if (passage == Passage::Cancelled) {
    process_->kill();
    return Error{.code = Code::CANCELLED, .what = "the work was cancelled " + doing};
  }
  const auto end = process_->wait(kToExit);
  if (!end) process_->kill();  // it closed its socket but still runs
  const std::string limit =
      settings_.memory_mib == 0
          ? ""
          : ", within isolate-memory=" + std::to_string(settings_.memory_mib) + " MiB";
  return Error{.code = Code::WORKER_ENDED,
               .what = "the worker process of the model ended " + doing,
               .offered = end ? *end : "it closed its connection",
               .needed = "a model that does not crash" + limit,
               .fix = kRestartAndSave};
}

Error Worker::invalid_message(const std::string& doing, const std::string& how) {
  alive_ = false;
  process_->kill();
  return Error{.code = Code::WORKER_ENDED,
               .what = "the worker process of the model sent an invalid message " + doing,
               .offered = how,
               .needed = "a valid message: the module has corrupted the memory of its process",
               .fix = kRestartAndSave};
}

Status Worker::ask(Kind kind, const io::Deadline& until, const std::string& doing) {
  auto passage = channel_.send(writer_.finish(), until);
  if (passage == Passage::Done) passage = channel_.receive(until, &response_);
  if (passage == Passage::Unreadable)
    return invalid_message(doing, "a message that exceeds all limits");
  if (passage != Passage::Done) return lost(passage, doing);
  if (response_.kind == kind) return ok();
  if (response_.kind != Kind::Failed)
    return invalid_message(doing, "an unexpected kind of message");
  MessageReader failed(response_.body);
  Error error = take_error(&failed);
  if (!failed.complete()) return invalid_message(doing, "an error that cannot be read");
  if (error.code == Code::OUT_OF_MEMORY && settings_.memory_mib > 0) {
    alive_ = false;
    process_->kill();
    return Error{.code = Code::WORKER_ENDED,
                 .what = "the model exceeded its memory limit " + doing,
                 .offered = error.what,
                 .needed = "isolate-memory=" + std::to_string(settings_.memory_mib) + " MiB",
                 .fix = "isolate-memory=" + std::to_string(2 * settings_.memory_mib)};
  }
  return error;
}

Status Worker::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  const std::string doing = "while it computed shapes";
  writer_.begin(Kind::Resolve);
  put_infos(in, &writer_);
  put_infos(out, &writer_);
  if (auto status = ask(Kind::Resolved, deadline(kOnce), doing); !status) return status;
  MessageReader resolved(response_.body);
  const auto infos = TensorInfos::take(&resolved);
  execution_.threads = resolved.take<uint32_t>();
  execution_.spins = resolved.take<uint32_t>();
  if (!resolved.complete() || infos.list().size() != out.size())
    return invalid_message(doing, "shapes that cannot be read");
  if (!std::all_of(infos.list().begin(), infos.list().end(), has_legal_rank))
    return invalid_message(doing, "a rank beyond the limit");
  for (size_t i = 0; i < out.size(); ++i) {
    const char* name = out[i].name;
    out[i] = infos.list()[i];
    out[i].name = name;
  }
  return ok();
}

Status Worker::control(int op, const weir_option* option) {
  writer_.begin(Kind::Control);
  writer_.put(static_cast<int32_t>(op));
  writer_.put<uint8_t>(option != nullptr);
  writer_.text(option && option->key ? option->key : "");
  writer_.text(option && option->value ? option->value : "");
  return ask(Kind::Done, deadline(kOnce), "while it handled a control call");
}

}  // namespace weir::isolate
