// ONNX metadata_props of the category Image.
#include "core/card/metadata.hpp"

namespace weir::card {
namespace {

std::optional<Color> color_of(const std::string& format) {
  if (format == "Gray8") return Color::Gray;
  if (format == "Rgb8") return Color::Rgb;
  if (format == "Bgr8") return Color::Bgr;
  return std::nullopt;
}

// False for ranges that a multiplication of bytes does not reach (16 to 235: video levels).
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

}  // namespace

std::optional<ImageInput> input_from_metadata(const std::map<std::string, std::string>& properties,
                                              ImageInput asked) {
  const auto value = [&properties](const char* key) {
    const auto at = properties.find(key);
    return at == properties.end() ? std::string() : at->second;
  };
  const auto color = color_of(value("Image.BitmapPixelFormat"));
  if (!color || asked.channels() != (*color == Color::Gray ? 1 : 3)) return std::nullopt;
  asked.color = *color;
  if (!set_range(value("Image.NominalPixelRange"), &asked)) return std::nullopt;
  return asked;
}

}  // namespace weir::card
