// What the engines of these tests open: the ABI leaves both types to the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

struct weir_model {
  int number;
};
struct weir_session {
  weir_model* model;
};
