// The models of `weir serve`: arguments, and the pipeline that serves them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "commands.hpp"
#include "launch/pipeline_description.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Where a server listens.
struct ListenAddress {
  std::string host, port;  // of TCP; an IPv6 address has no brackets
  std::string unix_path;   // of a Unix socket; then the other two are ""

  // "127.0.0.1:8001", "[::1]:8001", "unix:/run/weir.sock". OPTION_VALUE.
  static Result<ListenAddress> parse(const std::string& text, const char* option);
  std::string text() const;
  // Whether only programs of this machine can connect.
  bool is_local() const;
};

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
