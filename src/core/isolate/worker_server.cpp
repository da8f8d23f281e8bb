// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/worker_server.hpp"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/module_library.hpp"

namespace weir::isolate {
namespace {

Error unreadable() {
  return Error{.code = Code::INTERNAL, .what = "a worker process cannot read a request"};
}

// The choice from the property accelerator; that of the caller where it has none.
AcceleratorChoice choose_accelerator(const OpenCall& call, const weir_engine& engine) {
  const auto given =
      std::ranges::find(call.declared, "accelerator", &std::pair<std::string, std::string>::first);
  if (given == call.declared.end()) return {call.accelerator};
  const auto request = infer::parse_accelerator(given->second);
  const auto supported = infer::list_accelerators(engine);
  return {infer::choose_accelerator(request, supported),
          infer::unavailable_hardware(request, supported, engine.name, given->second)};
}

}  // namespace

WorkerServer::~WorkerServer() {
  release_outputs();
  if (session_) model_->engine().session_free(session_);
}

bool WorkerServer::serve(const Confinement& confinement) {
  writer_.begin(Kind::Hello);
  writer_.put(kProtocol);
  writer_.text(confinement.text);
  writer_.text(confinement.refused);
  auto passage = channel_.send(writer_.finish(), {});
  Message message;
  while (passage == Passage::Done) {
    passage = channel_.receive({}, &message);
    if (passage != Passage::Done) break;
    MessageReader call(message.body);
    if (message.kind == Kind::Block) {
      keep_block(&message);
      continue;
    }
    if (message.kind == Kind::Forget) {
      forget_block(&call);
      continue;
    }
    if (const Status status = handle_message(&message); !status) {
      writer_.begin(Kind::Failed);
      put_error(status.error(), &writer_);
    }
    passage = channel_.send(writer_.finish(), {});
  }
  return passage == Passage::Ended;
}

Status WorkerServer::handle_message(Message* message) {
  MessageReader call(message->body);
  if (message->kind == Kind::Open) return open(&call);
  if (!session_) return unreadable();
  switch (message->kind) {
    case Kind::Resolve:
      return resolve(&call);
    case Kind::Invoke:
      return invoke(&call);
    case Kind::Fetch:
      return fetch(&call);
    case Kind::Control:
      return control(&call);
    default:
      return unreadable();
  }
}

Status WorkerServer::open(MessageReader* message) {
  const auto call = OpenCall::take(message);
  if (!message->complete() || model_) return unreadable();
  auto& library = infer::ModuleLibrary::instance();
  const auto engine =
      call.engine.empty() ? library.engine_for_model(call.paths) : library.engine(call.engine);
  if (!engine) return engine.error();
  if (call.paths.empty() && ((*engine)->flags & WEIR_ENGINE_NEEDS_NO_MODEL) == 0)
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no model is set",
                 .offered = "model=\"\"",
                 .needed = "the path of a model file; weir models list prints models to try",
                 .fix = "model=/path/to/model"};
  infer::OpenOptions options;
  options.paths = call.paths;
  options.options = call.options;
  options.declared = call.declared;
  const auto accelerator = choose_accelerator(call, **engine);
  options.accelerator = accelerator.used;
  options.threads = call.threads;
  auto model = infer::Model::open(**engine, options);
  if (!model) return model.error();
  weir_error error;
  weir_session* session = nullptr;
  const int result = (*engine)->session_new((*model)->handle(), nullptr, 0, &session, &error);
  if (result < 0 || !session)
    return infer::take_error(&error, result < 0 ? result : -WEIR_INTERNAL,
                             "no session could be created");
  model_ = *std::move(model);
  session_ = session;
  writer_.begin(Kind::Opened);
  put_model((*engine)->name, accelerator, model_->info(), &writer_);
  return ok();
}

Status WorkerServer::resolve(MessageReader* call) {
  const auto inputs = TensorInfos::take(call);
  auto outputs = TensorInfos::take(call);
  const auto legal = [](const TensorInfos& infos) {
    return std::ranges::all_of(infos.list(), has_legal_rank);
  };
  if (!call->complete() || !legal(inputs) || !legal(outputs)) return unreadable();
  if (const weir_engine& engine = model_->engine(); engine.resolve) {
    weir_error error;
    const int result =
        engine.resolve(session_, inputs.list().data(), static_cast<uint32_t>(inputs.list().size()),
                       outputs.list().data(), static_cast<uint32_t>(outputs.list().size()), &error);
    if (result < 0)
      return infer::take_error(&error, result, "the engine rejects these input shapes");
  }
  writer_.begin(Kind::Resolved);
  for (auto& info : outputs.list()) info.name = nullptr;  // the other side knows them
  put_infos(outputs.list(), &writer_);
  const auto execution = model_->execution().value_or(weir_execution{});
  writer_.put(execution.threads);
  writer_.put(execution.spins);
  return ok();
}

Status WorkerServer::control(MessageReader* call) {
  const auto op = call->take<int32_t>();
  const bool with_option = call->take<uint8_t>() != 0;
  const std::string key = call->text(), value = call->text();
  if (!call->complete()) return unreadable();
  const weir_option option{key.c_str(), value.c_str()};
  if (auto done =
          infer::give_order(model_->engine(), session_, op, with_option ? &option : nullptr);
      !done)
    return done;
  writer_.begin(Kind::Done);
  return ok();
}

void WorkerServer::keep_block(Message* message) {
  MessageReader reader(message->body);
  const auto call = reader.take<BlockCall>();
  Mapping mapping(message->descriptor.get(), call.bytes, call.writable != 0);
  if (mapping) blocks_[call.id] = std::move(mapping);
}

void WorkerServer::forget_block(MessageReader* call) {
  blocks_.erase(call->take<uint64_t>());
}

std::byte* WorkerServer::at(uint64_t block, uint64_t offset, uint64_t bytes) {
  const auto found = blocks_.find(block);
  if (found == blocks_.end()) return nullptr;
  const size_t size = found->second.bytes();
  return offset <= size && bytes <= size - offset ? found->second.data() + offset : nullptr;
}

}  // namespace weir::isolate
