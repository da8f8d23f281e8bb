/* The module entry of a C test module with one engine. Include it first, then define `engine`. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#pragma once
#include "weir/abi.h"

static const weir_host* host; /* the host that loaded the module */
static const weir_engine engine;
static const weir_engine* const engines[] = {&engine, NULL};
static const weir_module module = {.struct_size = sizeof module,
                                   .abi_major = WEIR_ABI_MAJOR,
                                   .abi_minor = WEIR_ABI_MINOR,
                                   .engines = engines};

__attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* given) {
  host = given;
  return &module;
}
