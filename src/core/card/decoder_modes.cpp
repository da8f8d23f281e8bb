// A table. A test of tensor_decoder compares it with the decoders that Weir has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/decoder_modes.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace weir::card {
namespace {

using enum Value;

// Joins the options of all modes that read the outputs of a model as results with those of the
// heads.
template <size_t kCount>
constexpr auto results_with(const std::array<DecoderOption, kCount>& of_heads) {
  constexpr std::array<DecoderOption, 8> kShared{{{"threshold", Fraction},
                                                  {"iou", Fraction},
                                                  {"labels", File},
                                                  {"max-results", Count},
                                                  {"classes"},
                                                  {"head"},
                                                  {"input"},
                                                  {"name"}}};
  std::array<DecoderOption, kShared.size() + kCount> out;
  const auto rest = std::copy(kShared.begin(), kShared.end(), out.begin());
  std::copy(of_heads.begin(), of_heads.end(), rest);
  return out;
}

constexpr auto kDetection = results_with<9>({{{"unit"},
                                              {"scores"},
                                              {"keypoints"},
                                              {"anchors"},
                                              {"priors", File},
                                              {"scales"},
                                              {"first-class"},
                                              {"pixel-threshold"},
                                              {"unclip"}}});
constexpr auto kClassification = results_with<1>({{{"scores"}}});
constexpr auto kSegmentation = results_with<2>({{{"unit"}, {"scores"}}});
constexpr auto kPose = results_with<2>({{{"unit"}, {"keypoints"}}});
constexpr auto kDepth = results_with<0>({});
constexpr auto kText = results_with<2>({{{"pixel-threshold"}, {"unclip"}}});

constexpr DecoderOption kJson[] = {{"labels", Files}, {"threshold", Fraction}, {"masks"}};
constexpr DecoderOption kCoco[] = {{"labels", Files}, {"threshold", Fraction}, {"categories"}};
constexpr DecoderOption kLines[] = {{"labels", Files}, {"threshold", Fraction}};

constexpr DecoderOption kImageLabeling[] = {{"option1", File}};
constexpr DecoderOption kDirectVideo[] = {{"option1"}};
constexpr DecoderOption kBoundingBoxes[] = {{"option1"}, {"option2", File}, {"option3", Parameters},
                                            {"option4"}, {"option5"},       {"option6"},
                                            {"option7"}};
constexpr DecoderOption kImageSegment[] = {{"option1"}, {"option2"}};
constexpr DecoderOption kPoseEstimation[] = {
    {"option1"}, {"option2"}, {"option3", File}, {"option4"}};
constexpr DecoderOption kTensorRegion[] = {
    {"option1"}, {"option2", File}, {"option3", FileFirst}, {"option4"}};

constexpr DecoderMode kModes[] = {
    {"image_labeling", kImageLabeling},
    {"detection", kDetection},
    {"classification", kClassification},
    {"segmentation", kSegmentation},
    {"pose", kPose},
    {"depth", kDepth},
    {"text", kText},
    {"bounding_boxes", kBoundingBoxes},
    {"bounding_box", kBoundingBoxes},  // the other name of bounding_boxes
    {"image_segment", kImageSegment},
    {"pose_estimation", kPoseEstimation},
    {"tensor_region", kTensorRegion},
    {"direct_video", kDirectVideo},
    {"octet_stream", {}},
    {"json", kJson},
    {"webvtt", kLines},
    {"coco", kCoco},
    {"mot", kLines},
    {"protobuf", {}},
    {"flatbuf", {}},
    {"flexbuf", {}},
};

constexpr std::string_view kProperties[] = {"threshold", "iou", "labels", "max-results", "classes"};

}  // namespace

const DecoderOption* DecoderMode::option(std::string_view wanted) const noexcept {
  const auto found = std::find_if(options.begin(), options.end(),
                                  [&](const DecoderOption& one) { return one.name == wanted; });
  return found == options.end() ? nullptr : &*found;
}

bool DecoderMode::is_numbered() const noexcept {
  return options.empty() || options[0].name == "option1";
}

std::span<const DecoderMode> decoder_modes() noexcept {
  return kModes;
}

const DecoderMode* find_decoder_mode(std::string_view name) noexcept {
  const auto* found = std::find_if(std::begin(kModes), std::end(kModes),
                                   [&](const DecoderMode& mode) { return mode.name == name; });
  return found == std::end(kModes) ? nullptr : found;
}

bool is_decoder_property(const DecoderOption& option) noexcept {
  return option.name.starts_with("option") ||
         std::find(std::begin(kProperties), std::end(kProperties), option.name) !=
             std::end(kProperties);
}

}  // namespace weir::card
