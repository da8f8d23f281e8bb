// Builds the pipeline text that prepares pictures as a card describes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>

#include "core/card/card.hpp"
#include "weir/join.hpp"

namespace weir::card {
namespace {

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

std::string numbers(const std::vector<double>& values) {
  return join(values, ",", decimal);
}

// Classic elements letterbox with black borders only.
std::string letterbox(const ImageInput& input) {
  const char* order = input.color == Color::Bgr ? " channel-order=BGR" : "";
  if (input.color == Color::Gray) order = " channel-order=GRAY";
  std::string out = "tensor_preprocess width=" + std::to_string(input.width()) +
                    " height=" + std::to_string(input.height()) +
                    " fit=letterbox padding-value=" + std::to_string(input.padding) + order;
  if (input.layout == Layout::Nchw) out += " layout=NCHW";
  if (!input.mean.empty()) out += " mean=" + numbers(input.mean);
  if (!input.scale.empty()) out += " scale=" + numbers(input.scale);
  return out + " type=" + std::string(to_string(input.type));
}

}  // namespace

std::string preparation(const ImageInput& input) {
  if (input.resize == Fit::Letterbox) return letterbox(input);
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
  if (input.layout == Layout::Nchw) out += " ! tensor_transform mode=transpose option=1:2:0:3";
  return out;
}

}  // namespace weir::card
