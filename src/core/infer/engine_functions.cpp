// Orders to engines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/engine_functions.hpp"

#include "core/infer/host.hpp"

namespace weir::infer {

Status give_order(const weir_engine& engine, weir_session* session, int order,
                  const weir_option* option) {
  const auto control = function_of(engine, &weir_engine::control);
  if (!control)
    return Error{Code::MODEL_UNSUPPORTED,
                 "the engine takes no orders besides frames",
                 engine.name,
                 "an engine with control",
                 "",
                 ""};
  weir_error error;
  const int result = control(session, order, option, &error);
  if (result < 0) return take_error(&error, result, "the engine does not do what it is told");
  return ok();
}

}  // namespace weir::infer
