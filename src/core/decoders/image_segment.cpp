// Turns the scores, class numbers or depths of each pixel into colours
// (docs/compatibility/decoder.md 5.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/decoders/stream_model.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/segmentation.hpp"
#include "core/draw/rgba_frame.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "weir/decoder.hpp"

namespace weir::decoders {
namespace {

constexpr char kSegmentOptions[] =
    R"([{"name":"option1","type":"tflite-deeplab|snpe-deeplab|snpe-depth","default":"",)"
    R"("help":"Content of the tensor: scores, class numbers or depths"},)"
    R"({"name":"option2","type":"integer","default":"20",)"
    R"("help":"Number of classes besides the background"}])";

constexpr uint64_t kMaxLabels = 65535;
constexpr float kThreshold = 0.5f;  // a class needs a greater score
constexpr size_t kPart = 2048;  // pixels that are decoded and painted while they are in the cache

enum class Scheme { Scores, ClassNumbers, Depths };
constexpr std::array kSegmentSchemes{Scheme::Scores, Scheme::ClassNumbers, Scheme::Depths};

Scheme read_scheme(const Options& options) {
  static const std::vector<std::string> names{"tflite-deeplab", "snpe-deeplab", "snpe-depth"};
  const std::string name(options.get("option1").value_or(""));
  if (const auto found = std::find(names.begin(), names.end(), name); found != names.end())
    return kSegmentSchemes[static_cast<size_t>(found - names.begin())];
  if (!name.empty()) {
    Error error = not_one_of("option1 is not a kind of segmentation", "option1=" + name, names);
    const std::string close = nearest(name, names);
    error.difference = close.empty() ? "" : "did you mean " + close + "?";
    error.fix = "option1=" + (close.empty() ? names[0] : close);
    throw Failure(std::move(error));
  }
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "mode=image_segment does not know what the tensor holds",
                 .offered = "no option1",
                 .needed = one_of(names),
                 .fix = "tensor_decoder mode=image_segment option1=" + names[0]});
}

// The number of classes including the background.
size_t read_classes(const Options& options) {
  const std::string text(options.get("option2").value_or(""));
  if (text.empty()) return 21;
  const auto labels = parse_unsigned(strip(text));
  if (labels && *labels > 0 && *labels <= kMaxLabels) return *labels + 1;
  throw Failure({.code = labels ? Code::OPTION_VALUE : Code::OPTION_SYNTAX,
                 .what = "option2 is not a number of classes",
                 .offered = "option2=" + text,
                 .needed = "a whole number from 1 to " + std::to_string(kMaxLabels) +
                           ", without the background",
                 .fix = "option2=20"});
}

class ImageSegment {
 public:
  explicit ImageSegment(const Options& options)
      : scheme_(read_scheme(options)),
        classes_(scheme_ == Scheme::Depths ? 1 : read_classes(options)),
        colors_(draw::spread_colors(classes_)) {}

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    if (inputs.empty())
      throw Failure({.code = Code::FORMAT_UNSUPPORTED,
                     .what = "mode=image_segment needs the size of the picture",
                     .offered = "a flexible stream, in which each frame has its own size",
                     .needed = "a static stream",
                     .fix = "tensor_converter ! tensor_decoder"});
    size_ = get_size(inputs[0]);
    output.set_caps("video/x-raw,format=(string)RGBA,width=(int)" + std::to_string(size_.width) +
                    ",height=(int)" + std::to_string(size_.height));
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    if (frame.n_tensors == 0)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "mode=image_segment got a frame without tensors",
                     .offered = "0 tensors",
                     .needed = "one tensor"});
    const weir_tensor& tensor = frame.tensors[0];
    size_ = get_size(tensor.info);
    const std::span<const float> values = values_.read(tensor);
    const std::span<std::byte> bytes = output.reserve(draw::rgba_bytes(size_));
    const std::span pixels(reinterpret_cast<draw::Rgba*>(bytes.data()),
                           size_t{size_.width} * size_.height);
    if (scheme_ == Scheme::Depths)
      paint_depths(values, pixels);
    else
      paint_classes(values, pixels);
    return true;
  }

 private:
  // The first dimension of a pixel: its number of values; 0 if pixels have no dimension of their
  // own.
  size_t values_per_pixel() const {
    return scheme_ == Scheme::Scores ? classes_ : scheme_ == Scheme::Depths ? 1 : 0;
  }
  std::string example() const {
    const size_t values = values_per_pixel();
    return (values > 0 ? std::to_string(values) + ":" : "") + "257:257";
  }

  Size get_size(const weir_tensor_info& info) const {
    const size_t values = values_per_pixel();
    const uint32_t first = values > 0 ? 1 : 0;
    const int64_t width = dimension(info, first), height = dimension(info, first + 1);
    bool one_picture = info.type == WEIR_FLOAT32 && width > 0 && height > 0 && width <= INT32_MAX &&
                       height <= INT32_MAX;
    for (uint32_t i = first + 2; i < WEIR_RANK_LIMIT; ++i) one_picture &= dimension(info, i) == 1;
    const int64_t offered = dimension(info, 0);
    if (one_picture && (first == 0 || offered == static_cast<int64_t>(values)))
      return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
    throw wrong_tensor(info, one_picture && scheme_ == Scheme::Scores && offered > 1);
  }

  Failure wrong_tensor(const weir_tensor_info& info, bool only_classes_differ) const {
    const std::string needed[] = {
        "float32 " + std::to_string(classes_) + ":W:H, one score for each class and the background",
        "float32 W:H, a class number for each pixel", "float32 1:W:H, a depth for each pixel"};
    std::string fix = model_.float32_elements();
    if (only_classes_differ)
      fix = "option2=" + std::to_string(dimension(info, 0) - 1);
    else if (info.type == WEIR_FLOAT32)
      fix = "other/tensors,format=static,num_tensors=1,dimensions=(string)" + example() +
            ",types=float32";
    return Failure({.code = Code::SPEC_MISMATCH,
                    .what = only_classes_differ
                                ? "the tensor has a different number of classes than option2"
                                : "mode=image_segment cannot read this tensor as a picture",
                    .offered = describe(info),
                    .needed = needed[static_cast<size_t>(scheme_)],
                    .fix = std::move(fix)});
  }

  void paint_classes(std::span<const float> values, std::span<draw::Rgba> pixels) {
    std::array<uint16_t, kPart> map;
    const size_t step = scheme_ == Scheme::Scores ? classes_ : 1;
    for (size_t first = 0; first < pixels.size(); first += kPart) {
      const size_t count = std::min(kPart, pixels.size() - first);
      const auto part = values.subspan(first * step, count * step);
      const auto classes = std::span(map).first(count);
      if (scheme_ == Scheme::Scores)
        detection::classes_from_scores(part, classes_, kThreshold, classes);
      else if (const auto odd = detection::classes_from_numbers(part, classes_, classes))
        throw no_such_class(part[*odd], first + *odd);
      draw::paint_classes(classes, colors_, pixels.subspan(first, count));
    }
  }

  void paint_depths(std::span<const float> values, std::span<draw::Rgba> pixels) {
    const auto max = detection::max_depth(values);
    if (max.not_finite) throw not_finite(values[*max.not_finite], *max.not_finite);
    if (max.value == 0) {
      std::fill(pixels.begin(), pixels.end(), draw::kTransparent);
      return;
    }
    std::array<uint8_t, kPart> grays;
    for (size_t first = 0; first < pixels.size(); first += kPart) {
      const auto part = std::span(grays).first(std::min(kPart, pixels.size() - first));
      detection::grays_from_depths(values.subspan(first, part.size()), max.value, part);
      draw::paint_grays(part, pixels.subspan(first, part.size()));
    }
  }

  std::string place(float value, size_t pixel) const {
    char text[32];
    snprintf(text, sizeof text, "%g", static_cast<double>(value));
    return std::string(text) + " at pixel " + std::to_string(pixel % size_.width) + ", " +
           std::to_string(pixel / size_.width);
  }
  Failure no_such_class(float value, size_t pixel) const {
    const bool too_great = value >= 0 && value <= static_cast<float>(kMaxLabels);
    return Failure({.code = Code::SPEC_MISMATCH,
                    .what = "a pixel has a number that is not a class",
                    .offered = place(value, pixel),
                    .needed = "numbers from 0 to " + std::to_string(classes_ - 1) +
                              " (option2=" + std::to_string(classes_ - 1) + ")",
                    .fix = too_great ? "option2=" + std::to_string(static_cast<int>(value))
                                     : "option1=tflite-deeplab if the tensor holds scores"});
  }
  Failure not_finite(float value, size_t pixel) const {
    return Failure({.code = Code::SPEC_MISMATCH,
                    .what = "a depth is not a finite number",
                    .offered = place(value, pixel),
                    .needed = "finite depths; the greatest becomes white",
                    .fix = "tensor_transform mode=clamp option=0:1000 limits infinite depths; "
                           "not-a-number is a fault of the model"});
  }

  Scheme scheme_;
  size_t classes_;  // including the background
  std::vector<draw::Rgba> colors_;
  Size size_;
  StreamModel model_;
  TensorValues values_;
};

}  // namespace

const weir_decoder_type& image_segment() {
  static const weir_decoder_type table =
      decoder_table<ImageSegment>("image_segment", "", kSegmentOptions);
  return table;
}

}  // namespace weir::decoders
