// The schemes of bounding_boxes for SSD models, among them MediaPipe's palm detector and OpenVINO's
// person and face detectors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <limits>

#include "core/decoders/box_scheme.hpp"
#include "core/decoders/option_text.hpp"
#include "core/decoders/scheme_checks.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/anchors.hpp"
#include "core/detection/box_layouts.hpp"
#include "core/detection/pixel_box.hpp"
#include "core/text/text.hpp"
#include "core/text/text_file.hpp"

namespace weir::decoders {
namespace {

// Models that end in TFLite_Detection_PostProcess.
class MobilenetSsdPostprocess final : public BoxScheme {
 public:
  explicit MobilenetSsdPostprocess(const SchemeOptions& options) : options_(options) {
    if (!options.parameters.empty()) read_parameters();
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed =
        "4 tensors of one type: boxes 4:N, classes N, scores N, count 1, with N up to 100, in the "
        "order that option3 gives";
    check_count_and_type(options_, tensors, kTensors, needed);
    const int64_t rows = dimension(*tensors[index_[kScores]], 0);
    const bool good = rows > 0 && rows <= kMaxRows &&
                      has_dimensions(*tensors[index_[kBoxes]], {4, rows}) &&
                      has_dimensions(*tensors[index_[kClasses]], {rows}) &&
                      has_dimensions(*tensors[index_[kScores]], {rows}) &&
                      has_dimensions(*tensors[index_[kCount]], {1});
    if (!good) throw wrong_tensors(options_, tensors, needed, "option3=0:1:2:3,50");
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    std::array<std::span<const float>, kTensors> values;
    for (size_t i = 0; i < kTensors; ++i) values[i] = values_[i].read(tensors[index_[i]]);
    const auto found = detection::decode({.boxes = values[kBoxes],
                                          .classes = values[kClasses],
                                          .scores = values[kScores],
                                          .count = values[kCount][0]},
                                         threshold_, options_.input);
    return detection::to_pixels(found, detection::Limits::None, options_.input);
  }

 private:
  enum Role : size_t { kBoxes, kClasses, kScores, kCount, kTensors };
  static constexpr int64_t kMaxRows = 100;

  void read_parameters() {
    const auto failure = [this](std::string offered) {
      return Failure({.code = Code::OPTION_SYNTAX,
                      .what = "option3 is not what option1=" + options_.name + " takes",
                      .offered = std::move(offered),
                      .needed = "BOXES:CLASSES:SCORES:COUNT,THRESHOLD: four different indices of "
                                "tensors from 0 to 3 and a percentage",
                      .fix = "option3=0:1:2:3,50"});
    };
    const std::string offered = "option3=" + options_.parameters;
    const auto halves = split(options_.parameters, ",");
    const auto indices = split(halves[0], ":");
    if (halves.size() != 2 || indices.size() != kTensors || strip(halves[1]).empty())
      throw failure(offered);
    std::array<bool, kTensors> seen{};
    for (size_t i = 0; i < kTensors; ++i) {
      const auto index = parse_unsigned(strip(indices[i]));
      if (!index || *index >= kTensors || seen[*index]) throw failure(offered);
      seen[*index] = true;
      index_[i] = static_cast<size_t>(*index);
    }
    std::string_view percent = strip(halves[1]);
    if (percent.ends_with('%')) percent.remove_suffix(1);
    const float value = read_number(options_, percent, "threshold", 0);
    if (value >= 0 && value <= 100) {
      threshold_ = value / 100;
      return;
    }
    // Pipelines with such a threshold have always run, with the default one.
    const std::string text =
        "the threshold of " + offered + " is not from 0 to 100 percent and has no effect";
    module_host->log(WEIR_LOG_ERROR, "bounding_boxes", text.c_str());
  }

  SchemeOptions options_;
  std::array<size_t, kTensors> index_{3, 1, 2, 0};  // of the tensor with each role
  float threshold_ = std::numeric_limits<float>::min();
  std::array<TensorValues, kTensors> values_;
};

// Models whose boxes are relative to the prior boxes of a file.
class MobilenetSsd final : public BoxScheme {
 public:
  MobilenetSsd(const SchemeOptions& options, detection::SsdClass choice)
      : options_(options), choice_(choice) {
    constexpr size_t kMaxParameters = 7;
    const auto parts = split_parameters(
        options_, kMaxParameters,
        "PRIORS_FILE[:THRESHOLD[:Y_SCALE[:X_SCALE[:H_SCALE[:W_SCALE[:IOU_THRESHOLD]]]]]]");
    read_priors(std::string(parts[0]));
    threshold_ = read_number(options_, parts[1], "threshold", threshold_);
    scales_.y = read_scale(parts[2], "y scale", scales_.y);
    scales_.x = read_scale(parts[3], "x scale", scales_.x);
    scales_.height = read_scale(parts[4], "height scale", scales_.height);
    scales_.width = read_scale(parts[5], "width scale", scales_.width);
    max_overlap_ = read_number(options_, parts[6], "threshold of the overlap", max_overlap_);
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed =
        "2 tensors of one type: boxes 4:1:N and scores CLASSES:N, with N up to " +
        std::to_string(kMaxAnchors);
    check_count_and_type(options_, tensors, 2, needed);
    const weir_tensor_info &boxes = *tensors[0], &scores = *tensors[1];
    const int64_t classes = dimension(scores, 0), anchors = dimension(scores, 1);
    const bool good =
        classes > 0 && anchors > 0 && anchors <= kMaxAnchors &&
        has_dimensions(scores, {classes, anchors}) &&
        (has_dimensions(boxes, {4, 1, anchors}) || has_dimensions(boxes, {4, anchors}));
    if (!good) throw wrong_tensors(options_, tensors, needed);
    check_labels(options_, classes, LabelCount::AtLeast, scores);
    if (static_cast<size_t>(anchors) > priors_.size())
      throw wrong_tensors(options_, tensors,
                          "at most as many anchors as the file of option3 has prior boxes: " +
                              std::to_string(priors_.size()));
    classes_ = static_cast<size_t>(classes);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    const auto found = detection::decode(
        {.boxes = boxes_.read(tensors[0]), .scores = scores_.read(tensors[1]), .classes = classes_},
        priors_, scales_, threshold_, options_.input, choice_);
    return detection::suppress(
        detection::to_pixels(found, detection::Limits::Corner, options_.input), max_overlap_);
  }

 private:
  static constexpr int64_t kMaxAnchors = 2034;

  void read_priors(const std::string& path) {
    if (path.empty())
      throw Failure(
          {.code = Code::FILE_NOT_FOUND,
           .what = options_.setting() + " needs a file of prior boxes",
           .offered = options_.parameters.empty() ? "no option3" : "option3=" + options_.parameters,
           .needed = "a text file with 4 lines: y and x of the centres, heights, widths",
           .fix = "option3=/path/to/box_priors.txt"});
    auto priors = detection::parse_box_priors(read_text_file("option3", path));
    if (!priors) {
      Error error = priors.error();
      error.offered = "option3=" + path;
      throw Failure(std::move(error));
    }
    priors_ = *std::move(priors);
  }
  float read_scale(std::string_view text, const char* meaning, float otherwise) const {
    const float scale = read_number(options_, text, meaning, otherwise);
    if (scale != 0) return scale;
    throw Failure({.code = Code::OPTION_VALUE,
                   .what = std::string("the ") + meaning + " of option3 is 0",
                   .offered = "option3=" + options_.parameters,
                   .needed = "a number other than 0, since values are divided by it"});
  }

  SchemeOptions options_;
  detection::SsdClass choice_;
  detection::BoxPriors priors_;
  float threshold_ = 0.5f, max_overlap_ = 0.5f;
  detection::SsdScales scales_;
  size_t classes_ = 0;
  TensorValues boxes_, scores_;
};

constexpr char kGrammar[] =
    "THRESHOLD[:LAYERS[:MIN_SCALE[:MAX_SCALE[:X_OFFSET[:Y_OFFSET[:STRIDE...]]]]]], a stride for "
    "each of 1 to 7 layers";

class Palm final : public BoxScheme {
 public:
  explicit Palm(const SchemeOptions& options) : options_(options) {
    const auto parts = split_parameters(options_, kFirstStride + kMaxLayers, kGrammar);
    threshold_ = read_number(options_, parts[0], "threshold", 0.5f);
    detection::PalmAnchorOptions anchors;
    const std::vector<uint32_t> usual = anchors.strides;
    const size_t layers = read_count(parts[1], "number of layers", kMaxLayers, usual.size());
    anchors.min_scale = read_number(options_, parts[2], "minimum scale", anchors.min_scale);
    anchors.max_scale = read_number(options_, parts[3], "maximum scale", anchors.max_scale);
    anchors.x_offset = read_number(options_, parts[4], "x offset", anchors.x_offset);
    anchors.y_offset = read_number(options_, parts[5], "y offset", anchors.y_offset);
    anchors.strides.clear();
    for (size_t i = 0; i < layers; ++i)
      anchors.strides.push_back(read_count(parts[kFirstStride + i], "stride", kMaxStride,
                                           i < usual.size() ? usual[i] : 0));
    anchors_ = detection::make_palm_anchors(anchors);
  }

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed = "2 tensors of one type: boxes 18:N and scores 1:N, with N up to " +
                               std::to_string(std::min(kMaxRows, anchors_.size())) +
                               ", the number of anchors";
    check_count_and_type(options_, tensors, 2, needed);
    const int64_t rows = dimension(*tensors[0], 1);
    const bool good = rows > 0 &&
                      static_cast<size_t>(rows) <= std::min(kMaxRows, anchors_.size()) &&
                      has_dimensions(*tensors[0], {int64_t{detection::kPalmRow}, rows}) &&
                      has_dimensions(*tensors[1], {1, rows});
    if (!good) throw wrong_tensors(options_, tensors, needed);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    constexpr float kMaxOverlap = 0.05f;
    const auto found = detection::decode_palms(boxes_.read(tensors[0]), scores_.read(tensors[1]),
                                               anchors_, threshold_, options_.input);
    return detection::suppress(
        detection::to_pixels(found, detection::Limits::Corner, options_.input), kMaxOverlap);
  }

 private:
  static constexpr size_t kFirstStride = 6, kMaxLayers = 7, kMaxRows = 2016;
  static constexpr uint32_t kMaxStride = 192;  // pixels: one cell

  // A missing count is `otherwise`; 0 means that it must be given.
  uint32_t read_count(std::string_view text, const char* meaning, uint64_t max,
                      size_t otherwise) const {
    text = strip(text);
    const auto count = text.empty() ? std::optional<uint64_t>(otherwise) : parse_unsigned(text);
    if (count && *count > 0 && *count <= max) return static_cast<uint32_t>(*count);
    throw Failure({.code = Code::OPTION_VALUE,
                   .what = std::string("a ") + meaning + " of option3 cannot be used",
                   .offered = (text.empty() ? "none" : std::string(text)) +
                              " in option3=" + options_.parameters,
                   .needed = "a number from 1 to " + std::to_string(max) + " in " + kGrammar,
                   .fix = "option3=0.5:4:1.0:1.0:0.5:0.5:8:16:16:16"});
  }

  SchemeOptions options_;
  float threshold_;
  std::vector<detection::Anchor> anchors_;
  TensorValues boxes_, scores_;
};

class Openvino final : public BoxScheme {
 public:
  explicit Openvino(const SchemeOptions& options) : options_(options) {}

  void check(std::span<const weir_tensor_info* const> tensors) override {
    const std::string needed = "1 tensor 7:" + std::to_string(kRecords);
    check_count_and_type(options_, tensors, 1, needed);
    if (!has_dimensions(*tensors[0], {int64_t{detection::kOpenvinoRecord}, kRecords}))
      throw wrong_tensors(options_, tensors, needed);
  }

  detection::PixelBoxes find(std::span<const weir_tensor> tensors) override {
    constexpr float kThreshold = 0.8f;
    auto boxes = detection::to_pixels(
        detection::decode_openvino(records_.read(tensors[0]), kThreshold, options_.input),
        detection::Limits::None, options_.input);
    for (auto& box : boxes) box.class_index = -1, box.probability = 1;
    return boxes;
  }

 private:
  static constexpr int64_t kRecords = 200;

  SchemeOptions options_;
  TensorValues records_;
};

}  // namespace

std::unique_ptr<BoxScheme> open_mobilenet_ssd(const SchemeOptions& options) {
  return std::make_unique<MobilenetSsd>(options, detection::SsdClass::Best);
}

std::unique_ptr<BoxScheme> open_mobilenet_ssd_of_first_class(const SchemeOptions& options) {
  return std::make_unique<MobilenetSsd>(options, detection::SsdClass::First);
}

std::unique_ptr<BoxScheme> open_mobilenet_ssd_postprocess(const SchemeOptions& options) {
  return std::make_unique<MobilenetSsdPostprocess>(options);
}

std::unique_ptr<BoxScheme> open_palm(const SchemeOptions& options) {
  return std::make_unique<Palm>(options);
}

std::unique_ptr<BoxScheme> open_openvino(const SchemeOptions& options) {
  return std::make_unique<Openvino>(options);
}

}  // namespace weir::decoders
