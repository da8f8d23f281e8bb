// LaunchLine: a gst-launch-1.0 command that feeds a model made-up data of the right size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::app {

struct LaunchLine {
  std::string command;             // quoted for a shell
  std::vector<std::string> notes;  // what the command had to assume
};

// Formats as in caps and properties, "3:224:224:1": innermost first, ? for an open dimension.
std::string caps_order(const weir_tensor_info& info);
// "float32", or "?" if the stream decides.
std::string type_name(const weir_tensor_info& info);

// `weir inspect` with these options, for the same model and engine. Both may be "".
std::string inspect_command(const std::string& model, const std::string& framework,
                            const std::string& options);

// A `framework` that is not empty is added to tensor_filter. `preparation`: the elements between a
// video stream and tensor_filter according to a card; "" without one. `properties`: more properties
// of tensor_filter.
LaunchLine launch_line(const std::string& model, const std::string& framework,
                       const std::vector<weir_tensor_info>& inputs, const std::string& preparation,
                       const std::string& properties = "");
// Whether the model leaves the type, the rank or a dimension to the stream.
bool leaves_open(const weir_tensor_info& info);
// The inputs, with open dimensions replaced by the sizes that the command uses.
std::vector<weir_tensor_info> chosen_inputs(std::vector<weir_tensor_info> inputs);

}  // namespace weir::app
