// Invokes a session of an asynchronous engine: submit a frame, abandon the requests in flight.
// async_request.hpp implements the requests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>

#include "core/infer/model/model.hpp"
#include "core/infer/module/async_request.hpp"

namespace weir::infer {

// True if the engine has submit() and the model supports it.
bool answers_asynchronously(const Session& session) noexcept;
// Submits a frame. Returns false between abandon() and resume(); `receiver` is then not called.
// Precondition: answers_asynchronously(), and the caller has waited for a free slot.
Result<bool> submit(Session& session, const weir_frame& in,
                    const std::shared_ptr<RequestReceiver>& receiver);
// Abandons and cancels all requests in flight. Returns the number of receivers that are not called
// when their request ends.
size_t abandon(Session& session);

}  // namespace weir::infer
