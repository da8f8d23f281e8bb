// Parses the .cfg file of a Darknet network.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>

#include "opencv-dnn/dnn_description.hpp"

namespace weir::engine {
namespace {

std::string_view stripped(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

Error invalid(const std::string& offered) {
  return Error{
      .code = Code::MODEL_INVALID,
      .what = "the description of the network cannot be read",
      .offered = offered,
      .needed = "a .cfg of Darknet: [net] with width, height and channels, then its layers",
      .fix = "model=net.cfg,net.weights"};
}

}  // namespace

Result<DnnDescription> describe_darknet(std::string_view cfg) {
  DnnDescription out;
  int64_t channels = 3, height = 0, width = 0;
  std::string section;
  size_t line_number = 0;
  for (size_t at = 0; at < cfg.size(); ++line_number) {
    const size_t end = std::min(cfg.find('\n', at), cfg.size());
    const auto line = stripped(cfg.substr(at, end - at));
    at = end + 1;
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    const auto where = [&] { return "line " + std::to_string(line_number + 1) + ": "; };
    if (line.front() == '[') {
      if (line.back() != ']') return invalid(where() + "a section that is not closed");
      section = line.substr(1, line.size() - 2);
      if (section != "net" && section != "network") out.operators.insert(section);
      continue;
    }
    const size_t equals = line.find('=');
    if (section.empty() || equals == std::string_view::npos)
      return invalid(where() + std::string(line.substr(0, 40)));
    if (section != "net" && section != "network") continue;
    const auto key = stripped(line.substr(0, equals)), text = stripped(line.substr(equals + 1));
    int64_t* wanted = key == "channels" ? &channels
                      : key == "height" ? &height
                      : key == "width"  ? &width
                                        : nullptr;
    if (!wanted) continue;
    const auto [stop, bad] = std::from_chars(text.data(), text.data() + text.size(), *wanted);
    if (bad != std::errc{} || stop != text.data() + text.size() || *wanted < 1 || *wanted > 65536)
      return invalid(where() + std::string(line.substr(0, 40)));
  }
  if (height == 0 || width == 0 || out.operators.empty())
    return invalid("no width, no height or no layer");
  out.inputs.push_back({"data", WEIR_FLOAT32, true, {1, channels, height, width}});
  return out;
}

}  // namespace weir::engine
