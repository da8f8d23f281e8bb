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

struct Network {
  int64_t channels = 3, height = 0, width = 0;
  std::string section;
  DnnDescription description;

  bool is_in_net() const { return section == "net" || section == "network"; }
};

bool read_extent(std::string_view text, int64_t* out) {
  const auto [stop, bad] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return bad == std::errc{} && stop == text.data() + text.size() && *out >= 1 && *out <= 65536;
}

bool read_setting(std::string_view line, Network* out) {
  const size_t equals = line.find('=');
  if (out->section.empty() || equals == std::string_view::npos) return false;
  if (!out->is_in_net()) return true;
  const auto key = stripped(line.substr(0, equals)), text = stripped(line.substr(equals + 1));
  if (key == "channels") return read_extent(text, &out->channels);
  if (key == "height") return read_extent(text, &out->height);
  if (key == "width") return read_extent(text, &out->width);
  return true;
}

// Returns what is wrong with the line; "" if nothing is.
std::string read_line(std::string_view line, Network* out) {
  if (line.empty() || line.front() == '#' || line.front() == ';') return "";
  if (line.front() != '[') return read_setting(line, out) ? "" : std::string(line.substr(0, 40));
  if (line.back() != ']') return "a section that is not closed";
  out->section = line.substr(1, line.size() - 2);
  if (!out->is_in_net()) out->description.operators.insert(out->section);
  return "";
}

}  // namespace

Result<DnnDescription> describe_darknet(std::string_view cfg) {
  Network net;
  size_t line_number = 1;
  for (size_t at = 0; at < cfg.size(); ++line_number) {
    const size_t end = std::min(cfg.find('\n', at), cfg.size());
    const auto wrong = read_line(stripped(cfg.substr(at, end - at)), &net);
    if (!wrong.empty()) return invalid("line " + std::to_string(line_number) + ": " + wrong);
    at = end + 1;
  }
  if (net.height == 0 || net.width == 0 || net.description.operators.empty())
    return invalid("no width, no height or no layer");
  net.description.inputs.push_back(
      {"data", WEIR_FLOAT32, true, {1, net.channels, net.height, net.width}});
  return std::move(net.description);
}

}  // namespace weir::engine
