// The commands of NNStreamer, whose names are links to `weir`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "commands.hpp"

namespace weir::app {

// Runs the command that `name` stands for and returns its exit status; nullopt: a name of Weir's.
std::optional<int> by_another_name(const std::string& name, int argc, char** argv);
// The options of `weir pbtxt`, which is nnstreamer-parser too.
void add_pbtxt(CLI::App* command, PbtxtOptions* pbtxt);

}  // namespace weir::app
