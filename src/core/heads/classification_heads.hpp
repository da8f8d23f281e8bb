// The head of classifiers: one score for each class.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

extern const Family kClassifier;

}  // namespace weir::heads
