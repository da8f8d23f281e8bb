// PreprocessSettings: the properties of tensor_preprocess, and the request that they make.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <tuple>

#include "core/preprocess/request.hpp"
#include "core/preprocess/runner.hpp"
#include "core/tensor/geometry.hpp"
#include "elements/tensor_preprocess/region_preprocessor.hpp"
#include "gstcpp/element/property.hpp"

namespace weir {

// The choices of core/preprocess, plus Auto for unset properties.
enum class FitChoice : int32_t { Auto = -1, Stretch, Letterbox, CentreCrop };
enum class OrderChoice : int32_t { Auto = -1, Rgb, Bgr, Gray };
enum class LayoutChoice : int32_t { Auto = -1, Nhwc, Nchw };
enum class RegionsChoice : int32_t { None, Meta, Pad };

namespace gst {
template <>
struct EnumType<preprocess::Resize> {
  static GType type() {
    static const GEnumValue values[] = {{0, "The nearest pixel", "nearest"},
                                        {1, "Between the four nearest pixels", "bilinear"},
                                        {2, "The mean of the area, when shrinking", "area"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirPreprocessMethod", values);
    return t;
  }
};
template <>
struct EnumType<FitChoice> {
  static GType type() {
    static const GEnumValue values[] = {{-1, "As in the card, otherwise stretch", "auto"},
                                        {0, "The picture fills the tensor", "stretch"},
                                        {1, "The whole picture, with padding around", "letterbox"},
                                        {2, "The middle of the picture", "centre-crop"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirPreprocessFit", values);
    return t;
  }
};
template <>
struct EnumType<OrderChoice> {
  static GType type() {
    static const GEnumValue values[] = {{-1, "As in the card or the downstream caps", "auto"},
                                        {0, "Red, green, blue", "RGB"},
                                        {1, "Blue, green, red", "BGR"},
                                        {2, "One channel", "GRAY"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirPreprocessChannelOrder", values);
    return t;
  }
};
template <>
struct EnumType<RegionsChoice> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "The whole picture", "none"},
        {1, "Each GstVideoRegionOfInterestMeta of a buffer", "meta"},
        {2, "The boxes of the same time on the pad regions", "pad"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirPreprocessRegions", values);
    return t;
  }
};
template <>
struct EnumType<LayoutChoice> {
  static GType type() {
    static const GEnumValue values[] = {{-1, "As in the card or the downstream caps", "auto"},
                                        {0, "Channels innermost, C:W:H:1", "NHWC"},
                                        {1, "Channels outside, W:H:C:1", "NCHW"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirPreprocessLayout", values);
    return t;
  }
};
}  // namespace gst

struct PreprocessSettings {
  uint32_t width = 0, height = 0;
  preprocess::Resize method = preprocess::Resize::Bilinear;
  FitChoice fit = FitChoice::Auto;
  uint32_t padding_value = 0;
  OrderChoice channel_order = OrderChoice::Auto;
  std::string mean, scale, quantisation, type, sizes;
  LayoutChoice layout = LayoutChoice::Auto;
  std::string card, card_input, crop;
  uint64_t max_wait = 1000000000;
  RegionsChoice regions = RegionsChoice::None;
  uint32_t max_regions = 0;
  bool clip_regions = true;
  float region_scale = 1;
  std::string region_shift;
  bool square_regions = false;
  bool rotate_regions = false;
  uint32_t threads = 1;
};

inline constexpr std::tuple kPreprocessProperties{
    gst::Property{"width", &PreprocessSettings::width,
                  "Width of the tensor; 0 = from the card or the downstream caps",
                  gst::Changeable::InReady, 0u, preprocess::kSideLimit},
    gst::Property{"height", &PreprocessSettings::height,
                  "Height of the tensor; 0 = from the card or the downstream caps",
                  gst::Changeable::InReady, 0u, preprocess::kSideLimit},
    gst::Property{"sizes", &PreprocessSettings::sizes,
                  "Pyramid instead of width and height: comma list of the WIDTHxHEIGHT of each "
                  "layer, one tensor each, at most 16"},
    gst::Property{"regions", &PreprocessSettings::regions,
                  "Parts of the picture to crop, resize and stack into one batch"},
    gst::Property{"max-regions", &PreprocessSettings::max_regions,
                  "With regions: batch size of a static tensor, zeros after the last region; 0 = a "
                  "flexible tensor of all regions",
                  gst::Changeable::InReady, 0u, kRegionLimit},
    gst::Property{"clip-regions", &PreprocessSettings::clip_regions,
                  "With regions: clip regions at the edge of the picture; false = keep their "
                  "proportions and fill the outside with padding-value"},
    gst::Property{"region-scale", &PreprocessSettings::region_scale,
                  "With regions: the sides of each region are those of its box times this number, "
                  "about the same centre",
                  gst::Changeable::InReady, 0.01f, 100.0f},
    gst::Property{"region-shift", &PreprocessSettings::region_shift,
                  "With regions: X:Y, by how many of its own sides each box is moved to the right "
                  "and down, along the sides of a rotated box"},
    gst::Property{"square-regions", &PreprocessSettings::square_regions,
                  "With regions: the longer side of the box counts for both"},
    gst::Property{"rotate-regions", &PreprocessSettings::rotate_regions,
                  "With regions=pad: regions are rotated as the boxes of results are, so that they "
                  "are upright in the tensor; needs clip-regions=false"},
    gst::Property{"max-wait", &PreprocessSettings::max_wait,
                  "With regions=pad: maximum time in nanoseconds that a picture waits for its "
                  "boxes; pictures without boxes in time are dropped",
                  gst::Changeable::InReady, uint64_t{0}, uint64_t{24} * 3600 * 1000000000},
    gst::Property{"crop", &PreprocessSettings::crop,
                  "X:Y:WIDTH:HEIGHT, the part of each picture to use, in pixels (relative to the "
                  "crop of the buffer, if any); empty = all; applies from the next frame on",
                  gst::Changeable::WhilePlaying},
    gst::Property{"method", &PreprocessSettings::method, "How the picture is resized"},
    gst::Property{"fit", &PreprocessSettings::fit, "How the picture is fitted into the tensor"},
    gst::Property{"padding-value", &PreprocessSettings::padding_value,
                  "Pixel value around a letterboxed picture, and outside of the picture with "
                  "clip-regions=false, before mean and scale",
                  gst::Changeable::InReady, 0u, 255u},
    gst::Property{"channel-order", &PreprocessSettings::channel_order, "Channels of the tensor"},
    gst::Property{
        "mean", &PreprocessSettings::mean,
        "value = (pixel - mean) * scale; one number, or a comma list with one for each channel"},
    gst::Property{
        "scale", &PreprocessSettings::scale,
        "value = (pixel - mean) * scale; one number, or a comma list with one for each channel"},
    gst::Property{"quantisation", &PreprocessSettings::quantisation,
                  "SCALE:ZERO_POINT of integers: round(value / SCALE) + ZERO_POINT"},
    gst::Property{"type", &PreprocessSettings::type,
                  "uint8, int8, float16 or float32; empty = from the card or the downstream caps, "
                  "otherwise float32 with mean or scale and uint8 without"},
    gst::Property{"layout", &PreprocessSettings::layout, "Order of the tensor's dimensions"},
    gst::Property{"card", &PreprocessSettings::card,
                  "Path of a model card, which supplies the values of properties that are not set"},
    gst::Property{"card-input", &PreprocessSettings::card_input,
                  "Name or index (from 0 on) of the model input that the tensor is for, if the "
                  "card has several"},
    gst::Property{"threads", &PreprocessSettings::threads,
                  "Number of threads that process each frame, including the streaming thread",
                  gst::Changeable::InReady, 1u, static_cast<uint32_t>(preprocess::kThreadLimit)},
};

// Parses the property crop; nullopt = the whole picture. OPTION_SYNTAX with the position.
Result<std::optional<Rect>> parse_crop(const PreprocessSettings& settings);
// Errors: OPTION_VALUE for mutually exclusive properties, OPTION_SYNTAX and TYPE_SYNTAX with the
// position, those of card::read() and with_card().
Result<preprocess::Request> make_request(const PreprocessSettings& settings);

}  // namespace weir
