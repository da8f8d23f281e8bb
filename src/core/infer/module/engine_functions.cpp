// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/engine_functions.hpp"

#include "core/infer/module/host.hpp"

namespace weir::infer {

Status give_order(const weir_engine& engine, weir_session* session, int order,
                  const weir_option* option) {
  const auto control = get_function(engine, &weir_engine::control);
  if (!control)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the engine has no control function",
                 .offered = engine.name,
                 .needed = "an engine with control"};
  weir_error error;
  const int result = control(session, order, option, &error);
  if (result < 0) return take_error(&error, result, "the engine failed a control call");
  return ok();
}

}  // namespace weir::infer
