// SPDX-License-Identifier: LGPL-2.1-or-later
// As gst.hpp, for tests.
#include "gst.hpp"

#include <gst/check/gstharness.h>
#include <gtest/gtest.h>
