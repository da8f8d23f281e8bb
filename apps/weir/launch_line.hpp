// A gst-launch-1.0 command that feeds a model with made-up data of the right size.
#pragma once
#include <string>
#include <vector>

#include "weir/abi.h"

namespace weir::app {

struct LaunchLine {
  std::string command;             // for a shell
  std::vector<std::string> notes;  // what the line had to choose
};

// "3:224:224:1", as in caps and properties: innermost first, ? where the model leaves it open.
std::string caps_order(const weir_tensor_info& info);
// "float32", or "?" when the stream decides.
std::string type_name(const weir_tensor_info& info);

// `framework` is put into the line when it is not empty. `preparation` is what a card says of
// pictures, the elements between a video stream and tensor_filter; "" when there is no card.
// `properties`: further ones of tensor_filter.
LaunchLine launch_line(const std::string& model, const std::string& framework,
                       const std::vector<weir_tensor_info>& inputs, const std::string& preparation,
                       const std::string& properties = "");
// Whether the model leaves the type, the rank or a size to the stream.
bool leaves_open(const weir_tensor_info& info);
// The inputs with the sizes that such a line chooses where the model leaves them open.
std::vector<weir_tensor_info> chosen_inputs(std::vector<weir_tensor_info> inputs);

}  // namespace weir::app
