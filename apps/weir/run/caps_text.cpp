// Picks the fields that people look for.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/caps_text.hpp"

#include <gst/gst.h>

#include <string_view>

#include "gstcpp/buffer/caps_text.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

std::string field(const GstStructure* caps, const char* name) {
  const char* text = gst_structure_get_string(caps, name);
  return text ? text : "";
}

int number(const GstStructure* caps, const char* name) {
  int value = 0;
  gst_structure_get_int(caps, name, &value);
  return value;
}

// "640x480", "" if the caps have no size.
std::string size_text(const GstStructure* caps) {
  const int width = number(caps, "width"), height = number(caps, "height");
  return width > 0 && height > 0 ? std::to_string(width) + "x" + std::to_string(height) : "";
}

std::string rate_of(const GstStructure* caps) {
  int frames = 0, seconds = 0;
  if (!gst_structure_get_fraction(caps, "framerate", &frames, &seconds) || frames <= 0 ||
      seconds <= 0)
    return "";
  const double rate = static_cast<double>(frames) / seconds;
  return fixed(rate, frames % seconds == 0 ? 0 : 2) + " fps";
}

std::string sound_text(const GstStructure* caps) {
  const int rate = number(caps, "rate"), channels = number(caps, "channels");
  constexpr int kKilo = 1000;
  return rate <= 0 ? ""
                   : fixed(static_cast<double>(rate) / kKilo, rate % kKilo == 0 ? 0 : 1) +
                         " kHz, " + std::to_string(channels) + " ch";
}

// The first of a list, and how many more there are: "3:224:224 +1".
std::string first_of(std::string list) {
  size_t more = 0;
  for (const char c : list) more += c == ',' || c == '.' ? 1U : 0U;
  list.erase(std::min(list.find_first_of(",."), list.size()));
  return more == 0 ? list : list + " +" + std::to_string(more);
}

std::vector<std::string> lines_of(const GstStructure* caps) {
  const std::string_view type = gst_structure_get_name(caps);
  if (type == "video/x-raw") return {field(caps, "format") + " " + size_text(caps), rate_of(caps)};
  if (type == "audio/x-raw") return {field(caps, "format"), sound_text(caps)};
  if (type == "other/tensor") return {field(caps, "type"), field(caps, "dimension")};
  if (type == "other/tensors" && !field(caps, "types").empty())
    return {first_of(field(caps, "types")), first_of(field(caps, "dimensions"))};
  if (type == "other/tensors") return {std::string(type), field(caps, "format")};
  const std::string size = size_text(caps);
  return {std::string(type), size.empty() ? sound_text(caps) : size};
}

}  // namespace

std::vector<std::string> caps_lines(const std::string& text) {
  const auto caps = gst::caps_from_text(text);
  if (!caps || gst_caps_get_size(caps->get()) == 0) return {};
  auto lines = lines_of(gst_caps_get_structure(caps->get(), 0));
  std::erase_if(lines, [](const std::string& line) { return line.empty() || line == " "; });
  return lines;
}

}  // namespace weir::app
