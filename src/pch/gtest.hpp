// SPDX-License-Identifier: LGPL-2.1-or-later
// The headers of std.hpp and GoogleTest's.
#include "std.hpp"

#include <gtest/gtest.h>
