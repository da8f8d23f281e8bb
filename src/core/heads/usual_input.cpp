// The table of usual preparations of the families' authors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/usual_input.hpp"

#include <nlohmann/json.hpp>

#include "core/tensor/element_type.hpp"

namespace weir::heads {
namespace {

// The side of a picture where a model leaves it open, as published models have it.
constexpr int64_t kOpenSide = 640, kMaxPictureSide = 1 << 15;

struct Sides {
  int64_t height = kOpenSide, width = kOpenSide;
};

// Those in the metadata of a file of Ultralytics, "[416, 640]" or "416"; else the usual ones.
Sides read_sides(const char* metadata_json) {
  const auto all = nlohmann::json::parse(metadata_json ? metadata_json : "", nullptr, false);
  const auto map = all.is_object() ? all.value("custom_metadata_map", nlohmann::json::object())
                                   : nlohmann::json();
  const auto text = map.is_object() && map.contains("imgsz") && map["imgsz"].is_string()
                        ? map["imgsz"].get<std::string>()
                        : "";
  const auto value = nlohmann::json::parse(text, nullptr, false);
  const auto is_side = [](const nlohmann::json& side) {
    return side.is_number_integer() && side.get<int64_t>() > 0 &&
           side.get<int64_t>() <= kMaxPictureSide;
  };
  if (is_side(value)) return {value.get<int64_t>(), value.get<int64_t>()};
  if (value.is_array() && value.size() == 2 && is_side(value[0]) && is_side(value[1]))
    return {value[0].get<int64_t>(), value[1].get<int64_t>()};
  return {};
}

bool are_channels(int64_t extent) {
  return extent == 1 || extent == 3;
}

enum class PixelScale {
  Bytes,     // 0 to 255
  Unit,      // 0 to 1
  Signed,    // -1 to 1
  ImageNet,  // 0 to 1, less the mean of ImageNet, divided by its deviation
  Centred    // (pixel - 127) / 128
};

struct Usual {
  std::string_view begin;  // of the family's name
  PixelScale numbers;
  card::Fit resize;
  card::Color color = card::Color::Rgb;
  uint8_t padding = 0;
};

// How the authors' own code prepares pictures. The first row that fits counts.
constexpr Usual kUsual[] = {
    {"yolox", PixelScale::Bytes, card::Fit::Letterbox, card::Color::Bgr, 114},
    {"yolo", PixelScale::Unit, card::Fit::Letterbox, card::Color::Rgb, 114},
    {"fastestdet", PixelScale::Unit, card::Fit::Stretch, card::Color::Bgr},
    {"ssd", PixelScale::Signed, card::Fit::Stretch},
    {"detr", PixelScale::ImageNet, card::Fit::Stretch},
    {"rtdetr", PixelScale::Unit, card::Fit::Stretch},
    {"yunet", PixelScale::Bytes, card::Fit::Letterbox, card::Color::Bgr},
    {"ultraface", PixelScale::Centred, card::Fit::Stretch},
    {"blazeface", PixelScale::Signed, card::Fit::Letterbox},
    {"palm", PixelScale::Unit, card::Fit::Letterbox},
    {"blazepose-detection", PixelScale::Signed, card::Fit::Letterbox},
    {"blazepose", PixelScale::Unit, card::Fit::Letterbox},
    {"hand", PixelScale::Unit, card::Fit::Letterbox},
    {"face-landmarks", PixelScale::Unit, card::Fit::Letterbox},
    {"movenet", PixelScale::Bytes, card::Fit::Letterbox},
    {"posenet", PixelScale::Signed, card::Fit::Stretch},
    {"deeplab", PixelScale::Signed, card::Fit::Stretch},
    {"db", PixelScale::ImageNet, card::Fit::Letterbox, card::Color::Bgr},
    {"ctc", PixelScale::Signed, card::Fit::Letterbox, card::Color::Bgr, 127},
    {kUnknownFamily, PixelScale::Unit, card::Fit::Stretch},
    {"", PixelScale::ImageNet, card::Fit::Stretch}};

const Usual& find_usual(std::string_view family) {
  for (const Usual& usual : kUsual)
    if (family.starts_with(usual.begin)) return usual;
  return kUsual[std::size(kUsual) - 1];
}

void set_pixel_scale(PixelScale numbers, card::ImageInput* input) {
  switch (numbers) {
    case PixelScale::Bytes:
      return;
    case PixelScale::Unit:
      input->scale = {1 / 255.0};
      return;
    case PixelScale::Signed:
      input->mean = {127.5}, input->scale = {1 / 127.5};
      return;
    case PixelScale::Centred:
      input->mean = {127}, input->scale = {1 / 128.0};
      return;
    case PixelScale::ImageNet:
      input->mean = {123.675, 116.28, 103.53};
      input->scale = {1 / 58.395, 1 / 57.12, 1 / 57.375};
      return;
  }
}

const char* to_string(PixelScale numbers) {
  switch (numbers) {
    case PixelScale::Bytes:
      return "0 to 255";
    case PixelScale::Unit:
      return "0 to 1";
    case PixelScale::Signed:
      return "-1 to 1";
    case PixelScale::Centred:
      return "(pixel - 127) / 128";
    case PixelScale::ImageNet:
      return "the mean and deviation of ImageNet";
  }
  return "";
}

const char* to_string(card::Color color) {
  if (color == card::Color::Bgr) return "BGR";
  return color == card::Color::Gray ? "gray" : "RGB";
}

bool is_byte(const card::ImageInput& input) {
  return input.type == ElementType::UInt8 || input.type == ElementType::Int8;
}

std::string assumption(const card::ImageInput& input, PixelScale numbers) {
  return std::string("assumed: pixels as ") + (is_byte(input) ? "bytes" : to_string(numbers)) +
         ", " + to_string(input.color) +
         (input.resize == card::Fit::Letterbox ? ", letterboxed" : ", stretched") +
         ", as models of this kind usually are. If the results are wrong, write a card "
         "(docs/cards.md)";
}

}  // namespace

std::optional<card::ImageInput> usual_input(std::string_view family, const weir_tensor_info& info,
                                            std::string* note) {
  if (info.rank != 3 && info.rank != 4) return std::nullopt;
  const int64_t* const shape = info.shape + (info.rank - 3);
  const bool is_packed = are_channels(shape[2]);
  if (!is_packed && !are_channels(shape[0])) return std::nullopt;
  const Usual& usual = find_usual(family);
  card::ImageInput out;
  out.name = info.name ? info.name : "";
  out.type = info.type < WEIR_TYPE_END ? static_cast<ElementType>(info.type) : ElementType::Float32;
  out.layout = is_packed ? card::Layout::Nhwc : card::Layout::Nchw;
  out.shape = {1, shape[0], shape[1], shape[2]};
  out.color = out.channels() == 1 ? card::Color::Gray : usual.color;
  out.resize = usual.resize;
  out.padding = usual.padding;
  // Whole numbers are those of the pixels.
  if (!is_byte(out) && !(out.channels() == 1 && usual.numbers == PixelScale::ImageNet))
    set_pixel_scale(usual.numbers, &out);
  if (out.type == ElementType::Int8) out.mean = {128}, out.scale = {1};
  *note = assumption(out, usual.numbers);
  return out;
}

void set_open_sides(const char* metadata_json, weir_tensor_info* info) {
  const Sides sides = read_sides(metadata_json);
  const bool has_batch = info->rank == 4;
  const uint32_t first = has_batch ? 1 : 0;
  const bool is_planar = info->rank >= 3 && are_channels(info->shape[first]);
  const uint32_t rows = first + (is_planar ? 1 : 0);
  const auto side = [&](uint32_t i) -> int64_t {
    if (i == 0 && has_batch) return 1;
    if (i == rows) return sides.height;
    return i == rows + 1 ? sides.width : kOpenSide;
  };
  for (uint32_t i = 0; i < info->rank; ++i)
    if (info->shape[i] <= 0) info->shape[i] = side(i);
}

}  // namespace weir::heads
