// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/metadata.hpp"

#include "core/text/text.hpp"

namespace weir::card {
namespace {

std::optional<Color> parse_color(const std::string& format) {
  if (format == "Gray8") return Color::Gray;
  if (format == "Rgb8") return Color::Rgb;
  if (format == "Bgr8") return Color::Bgr;
  return std::nullopt;
}

// False for ranges that bytes cannot be scaled to (16 to 235: video levels).
bool set_range(const std::string& range, ImageInput* input) {
  if (range.empty() || range == "NominalRange_0_255") return true;
  if (range == "Normalized_0_1") {
    input->scale = {1.0 / 255};
    return true;
  }
  if (range == "Normalized_1_1") {
    input->mean = {127.5};
    input->scale = {1.0 / 127.5};
    return true;
  }
  return false;
}

using Properties = std::map<std::string, std::string>;

std::string find_value(const Properties& properties, const char* key) {
  const auto at = properties.find(key);
  return at == properties.end() ? std::string() : at->second;
}

// Empty if one of them is not a number or zero.
std::vector<double> divisors(const std::string& list) {
  std::vector<double> out;
  for (const auto part : split(list, ",")) {
    const auto number = parse_double(part);
    if (!number || *number == 0) return {};
    out.push_back(*number);
  }
  return out;
}

// Normalisation is given for real numbers: quantised inputs get the pixels, int8 shifted by 128.
std::optional<ImageInput> from_tflite(const Properties& properties, ImageInput image) {
  const std::string color = find_value(properties, "tflite.color_space");
  if (color != "RGB" && color != "GRAYSCALE") return std::nullopt;
  image.color = color == "RGB" ? Color::Rgb : Color::Gray;
  if (image.channels() != (color == "RGB" ? 3 : 1)) return std::nullopt;
  if (image.type == ElementType::UInt8) return image;
  if (image.type == ElementType::Int8) {
    image.mean = {128};
    image.scale = {1};
    return image;
  }
  // Owns the text that the parts view.
  const std::string means = find_value(properties, "tflite.mean");
  for (const auto part : split(means, ",")) image.mean.push_back(parse_double(part).value_or(0));
  for (const double divisor : divisors(find_value(properties, "tflite.std")))
    image.scale.push_back(1 / divisor);
  const auto fits = [&image](const std::vector<double>& values) {
    return values.size() == 1 || values.size() == static_cast<size_t>(image.channels());
  };
  return fits(image.mean) && fits(image.scale) ? std::optional(image) : std::nullopt;
}

}  // namespace

std::optional<ImageInput> input_from_metadata(const std::map<std::string, std::string>& properties,
                                              ImageInput image) {
  if (properties.contains("tflite.color_space")) return from_tflite(properties, std::move(image));
  const auto value = [&properties](const char* key) { return find_value(properties, key); };
  const auto color = parse_color(value("Image.BitmapPixelFormat"));
  if (!color || image.channels() != (*color == Color::Gray ? 1 : 3)) return std::nullopt;
  image.color = *color;
  if (!set_range(value("Image.NominalPixelRange"), &image)) return std::nullopt;
  return image;
}

std::vector<std::string> labels_from_metadata(
    const std::map<std::string, std::string>& properties) {
  std::vector<std::string> out;
  std::string text = find_value(properties, "tflite.labels");
  if (text.ends_with('\n')) text.pop_back();
  for (size_t begin = 0; !text.empty() && begin <= text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    if (out.back().ends_with('\r')) out.back().pop_back();
    begin = end + 1;
  }
  return out;
}

}  // namespace weir::card
