// InvokeEnd: how an engine ended an invoke, beside its error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::infer {

struct InvokeEnd {
  int reason = 0;           // what the engine returned: 0, or a weir_no_result
  std::string answered_by;  // the address of the server that answered; "" without servers
};

}  // namespace weir::infer
