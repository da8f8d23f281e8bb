// Reads the options and tensors of MediaPipe's palm detector.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/palm_scheme.hpp"

#include <algorithm>

#include "core/decoders/scheme_checks.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/palm_anchors.hpp"
#include "core/detection/pixel_suppression.hpp"
#include "core/text/text.hpp"

namespace weir::decoders {
namespace {

constexpr char kGrammar[] =
    "THRESHOLD[:LAYERS[:MIN_SCALE[:MAX_SCALE[:X_OFFSET[:Y_OFFSET[:STRIDE...]]]]]], a stride for "
    "each of 1 to 7 layers";

class Palm final : public BoxScheme {
 public:
  explicit Palm(const SchemeOptions& options) : options_(options) {
    const auto parts = split_parameters(options_, kFirstStride + kMostLayers, kGrammar);
    threshold_ = read_number(options_, parts[0], "threshold", 0.5f);
    detection::PalmAnchorOptions anchors;
    const std::vector<uint32_t> usual = anchors.strides;
    const size_t layers = read_count(parts[1], "number of layers", kMostLayers, usual.size());
    anchors.least_scale = read_number(options_, parts[2], "least scale", anchors.least_scale);
    anchors.greatest_scale =
        read_number(options_, parts[3], "greatest scale", anchors.greatest_scale);
    anchors.x_offset = read_number(options_, parts[4], "x offset", anchors.x_offset);
    anchors.y_offset = read_number(options_, parts[5], "y offset", anchors.y_offset);
    anchors.strides.clear();
    for (size_t i = 0; i < layers; ++i)
      anchors.strides.push_back(read_count(parts[kFirstStride + i], "stride", kLongestStride,
                                           i < usual.size() ? usual[i] : 0));
    anchors_ = detection::make_palm_anchors(anchors);
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed = "2 tensors of one type: boxes 18:N and scores 1:N, with N up to " +
                               std::to_string(std::min(kMostRows, anchors_.size())) +
                               ", the number of anchors";
    check_count_and_type(options_, tensors, 2, needed);
    const int64_t rows = dimension(*tensors[0], 1);
    const bool good = rows > 0 &&
                      static_cast<size_t>(rows) <= std::min(kMostRows, anchors_.size()) &&
                      has_dimensions(*tensors[0], {int64_t{detection::kPalmRow}, rows}) &&
                      has_dimensions(*tensors[1], {1, rows});
    if (!good) throw wrong_tensors(options_, tensors, needed);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    constexpr float kMostOverlap = 0.05f;
    const auto found = detection::decode_palms(boxes_.read(tensors[0]), scores_.read(tensors[1]),
                                               anchors_, threshold_, options_.input);
    return detection::suppress(
        detection::to_pixels(found, detection::Limits::Corner, options_.input), kMostOverlap);
  }

 private:
  static constexpr size_t kFirstStride = 6, kMostLayers = 7, kMostRows = 2016;
  static constexpr uint32_t kLongestStride = 192;  // pixels: one cell

  // A missing count is `otherwise`; 0 means that it must be given.
  uint32_t read_count(std::string_view text, const char* meaning, uint64_t most,
                      size_t otherwise) const {
    text = strip(text);
    const auto count = text.empty() ? std::optional<uint64_t>(otherwise) : parse_unsigned(text);
    if (count && *count > 0 && *count <= most) return static_cast<uint32_t>(*count);
    throw Failure({.code = Code::OPTION_VALUE,
                   .what = std::string("a ") + meaning + " of option3 cannot be used",
                   .offered = (text.empty() ? "none" : std::string(text)) +
                              " in option3=" + options_.parameters,
                   .needed = "a number from 1 to " + std::to_string(most) + " in " + kGrammar,
                   .fix = "option3=0.5:4:1.0:1.0:0.5:0.5:8:16:16:16"});
  }

  SchemeOptions options_;
  float threshold_;
  std::vector<detection::Anchor> anchors_;
  TensorValues boxes_, scores_;
};

}  // namespace

std::unique_ptr<BoxScheme> open_palm(const SchemeOptions& options) {
  return std::make_unique<Palm>(options);
}

}  // namespace weir::decoders
