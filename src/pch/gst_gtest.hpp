// The headers of gst.hpp and GoogleTest's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gst.hpp"

#include <gst/check/gstharness.h>
#include <gtest/gtest.h>
