// The models of `weir serve`: arguments, and the pipeline that serves them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "commands.hpp"
#include "launch/pipeline_description.hpp"
#include "serve/listen_address.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct NamedModel {
  std::string name;  // as clients call it
  std::string file;  // a path, or several with commas
};

// Reads "MODEL" and "NAME=MODEL", where MODEL is a file or a name of the catalogue. The default
// name is that of the catalogue, or that of the file without its extension. MODEL_NOT_FOUND;
// OPTION_VALUE for names that addresses cannot have and for names used twice.
Result<std::vector<NamedModel>> read_models(const std::vector<std::string>& arguments);

// Errors of options that contradict each other, in terms of the command.
Status check_options(const ServeOptions& options, const ListenAddress& address);

// A pipeline with the elements NAME-source, NAME-filter and NAME-sink.
// `id` pairs source and sink.
PipelineDescription serving_pipeline(const NamedModel& model, size_t id,
                                     const ServeOptions& options, const ListenAddress& address);

}  // namespace weir::app
