// SPDX-License-Identifier: LGPL-2.1-or-later
// The headers of gst.hpp and GoogleTest's.
#include "gst.hpp"

#include <gst/check/gstharness.h>
#include <gtest/gtest.h>
