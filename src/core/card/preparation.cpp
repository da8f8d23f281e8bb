// Builds the pipeline text that prepares pictures as a card describes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>

#include "core/card/card.hpp"
#include "weir/join.hpp"

namespace weir::card {
namespace {

constexpr char kPlanar[] = " ! tensor_transform mode=transpose option=1:2:0:3";

// Always with a decimal point or an exponent; tensor_transform reads other operands as integers.
std::string decimal(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string out(text, end);
  return out.find_first_of(".e") == std::string::npos ? out + ".0" : out;
}

bool per_channel(const std::vector<double>& values) {
  for (const double value : values)
    if (value != values[0]) return true;
  return false;
}

std::string steps(const char* op, const std::vector<double>& values, double sign, bool by_channel) {
  std::string out;
  const size_t count = by_channel ? values.size() : std::min<size_t>(values.size(), 1);
  for (size_t i = 0; i < count; ++i) {
    out += std::string(",") + op + ":" + decimal(sign * values[i]);
    if (by_channel) out += "@" + std::to_string(i);
  }
  return out;
}

// Repeats a single number for every channel if other lists are per channel.
std::vector<double> widened(const std::vector<double>& values, size_t channels, bool by_channel) {
  if (!by_channel || values.size() != 1) return values;
  return std::vector<double>(channels, values[0]);
}

std::string arithmetic(const ImageInput& input) {
  if (input.mean.empty() && input.scale.empty() && input.type == ElementType::UInt8) return "";
  const bool by_channel = per_channel(input.mean) || per_channel(input.scale);
  const auto channels = static_cast<size_t>(input.channels());
  std::string option = "typecast:float32";
  if (by_channel) option += ",per-channel:true@0";
  option += steps("add", widened(input.mean, channels, by_channel), -1, by_channel);
  option += steps("mul", widened(input.scale, channels, by_channel), 1, by_channel);
  std::string out =
      input.mean.empty() && input.scale.empty()
          ? " ! tensor_transform mode=typecast option=" + std::string(to_string(input.type))
          : " ! tensor_transform mode=arithmetic option=" + option;
  const bool cast_again =
      input.type != ElementType::Float32 && !(input.mean.empty() && input.scale.empty());
  if (cast_again)
    out += " ! tensor_transform mode=typecast option=" + std::string(to_string(input.type));
  return out;
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

void add_list(const char* name, const std::vector<double>& values,
              std::vector<std::pair<std::string, std::string>>* out) {
  if (!values.empty()) out->emplace_back(name, join(values, ",", number_text));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> preprocess_properties(const ImageInput& input) {
  std::vector<std::pair<std::string, std::string>> out{{"width", std::to_string(input.width())},
                                                       {"height", std::to_string(input.height())}};
  if (input.resize == Fit::Letterbox) {
    out.emplace_back("fit", "letterbox");
    out.emplace_back("padding-value", std::to_string(input.padding));
  }
  if (input.resize == Fit::Crop) out.emplace_back("fit", "centre-crop");
  if (input.color == Color::Bgr) out.emplace_back("channel-order", "BGR");
  if (input.color == Color::Gray) out.emplace_back("channel-order", "GRAY");
  if (input.layout == Layout::Nchw) out.emplace_back("layout", "NCHW");
  add_list("mean", input.mean, &out);
  add_list("scale", input.scale, &out);
  out.emplace_back("type", to_string(input.type));
  return out;
}

std::string preprocess_element(const ImageInput& input) {
  std::string out = "tensor_preprocess";
  for (const auto& [name, value] : preprocess_properties(input)) out += " " + name + "=" + value;
  return out;
}

std::string value_elements(const ImageInput& input) {
  const std::string values = arithmetic(input);
  const std::string turned = input.layout == Layout::Nchw ? kPlanar : "";
  const std::string all = values + turned;
  return all.empty() ? "" : all.substr(std::string_view(" ! ").size());
}

std::string preparation(const ImageInput& input) {
  // Classic elements letterbox with black borders only.
  if (input.resize == Fit::Letterbox) return preprocess_element(input);
  const char* format = input.color == Color::Gray  ? "GRAY8"
                       : input.color == Color::Rgb ? "RGB"
                                                   : "BGR";
  const std::string width = std::to_string(input.width()), height = std::to_string(input.height());
  std::string out = "videoconvert ! ";
  if (input.resize == Fit::Crop)
    out += "aspectratiocrop aspect-ratio=" + width + "/" + height + " ! ";
  out += std::string("videoscale add-borders=false ! video/x-raw,format=") + format +
         ",width=" + width + ",height=" + height + ",pixel-aspect-ratio=1/1 ! tensor_converter" +
         arithmetic(input);
  if (input.layout == Layout::Nchw) out += kPlanar;
  return out;
}

}  // namespace weir::card
