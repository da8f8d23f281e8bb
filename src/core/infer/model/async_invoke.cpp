// Calls submit() and cancel() of the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/async_invoke.hpp"

#include <utility>

#include "core/infer/module/engine_functions.hpp"
#include "core/infer/module/host.hpp"

namespace weir::infer {
namespace {

void cancel(Session& session, weir_request* request) {
  if (const auto call = function_of(session.model().engine(), &weir_engine::cancel))
    call(session.handle(), request);
}

}  // namespace

bool answers_asynchronously(const Session& session) noexcept {
  return function_of(session.model().engine(), &weir_engine::submit) &&
         (session.model().info().flags & WEIR_MODEL_ASYNC) != 0;
}

Result<bool> submit(Session& session, const weir_frame& in,
                    const std::shared_ptr<RequestReceiver>& receiver) {
  weir_request* request = session.requests().open(receiver);
  if (!request) return false;
  weir_error error;
  const int result = session.model().engine().submit(session.handle(), &in, request, &error);
  if (result == 0) {
    if (session.requests().begun(request)) cancel(session, request);
    return true;
  }
  if (!session.requests().withdraw(request)) return true;
  if (result < 0) return take_error(&error, result, "the engine rejected a frame");
  receiver->end(result);  // it drops the frame
  return true;
}

size_t abandon(Session& session) {
  const auto abandoned = session.requests().abandon();
  for (weir_request* request : abandoned.cancel) cancel(session, request);
  return abandoned.count;
}

}  // namespace weir::infer
