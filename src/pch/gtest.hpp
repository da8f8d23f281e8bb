// The headers of std.hpp and GoogleTest's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "std.hpp"

#include <gtest/gtest.h>
