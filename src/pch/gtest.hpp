// SPDX-License-Identifier: LGPL-2.1-or-later
// As std.hpp, for tests.
#include "std.hpp"

#include <gtest/gtest.h>
