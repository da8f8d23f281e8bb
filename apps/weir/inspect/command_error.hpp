// Writes errors about models and engines for the commands of `weir`, which have options instead of
// the properties of tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/result.hpp"

namespace weir::app {

// framework=NAME becomes --engine NAME, card=PATH becomes --card PATH, and model=PATH becomes PATH.
Error command_error(Error error);

}  // namespace weir::app
