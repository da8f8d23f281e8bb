// nnstreamer-check, nnstreamer-parser and nnstreamerCodeGenCustomFilter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "other_names.hpp"

#include <gst/gst.h>

namespace weir::app {

void add_pbtxt(CLI::App* command, PbtxtOptions* pbtxt) {
  command->add_flag("--from-pbtxt,-p", pbtxt->from_pbtxt, "The other direction; not implemented");
  command->add_flag("--verbose,-v", pbtxt->verbose, "Print elements and links on standard error");
  command->positionals_at_end();
  command->add_option("PIPELINE", pbtxt->pipeline, "The pipeline; default: read from stdin");
}

std::optional<int> by_another_name(const std::string& name, int argc, char** argv) {
  if (name != "nnstreamer-check" && name != "nnstreamer-parser" &&
      name != "nnstreamerCodeGenCustomFilter")
    return std::nullopt;
  CLI::App app{"Weir's command " + name, name};
  PbtxtOptions options;
  if (name == "nnstreamer-parser") add_pbtxt(&app, &options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitUsage;
  }
  if (name == "nnstreamer-parser") return pbtxt(options);
  if (name == "nnstreamerCodeGenCustomFilter") return ask_for_filter();
  gst_init(nullptr, nullptr);
  return check();
}

}  // namespace weir::app
