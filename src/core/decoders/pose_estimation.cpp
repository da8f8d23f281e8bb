// Finds key points in heat maps and draws them (docs/compatibility/decoder.md 5.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <algorithm>
#include <cmath>

#include "core/decoders/key_points.hpp"
#include "core/decoders/option_text.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/decoders/tensor_values.hpp"
#include "core/detection/pose.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "weir/decoder.hpp"

namespace weir::decoders {
namespace {

constexpr char kPoseOptions[] =
    R"([{"name":"option1","type":"string","default":"","help":"Size of the output, W:H"},)"
    R"({"name":"option2","type":"string","default":"",)"
    R"("help":"Size of the model's input, W:H; with heatmap-only that of the heat map"},)"
    R"({"name":"option3","type":"file","default":"",)"
    R"("help":"Key point file: a name and the indices of connected key points in each line"},)"
    R"({"name":"option4","type":"heatmap-only|heatmap-offset","default":"heatmap-only",)"
    R"("help":"heatmap-only, or heatmap-offset if a second tensor contains offsets"}])";

constexpr float kMinProbability = 0.5f;

bool read_has_offsets(const Options& options) {
  static const std::vector<std::string> names{"heatmap-only", "heatmap-offset"};
  const std::string name(options.get("option4").value_or(""));
  if (name.empty() || name == names[0]) return false;
  if (name == names[1]) return true;
  Error error = not_one_of("option4 is not a kind of heat map", "option4=" + name, names);
  const std::string close = nearest(name, names);
  error.difference = close.empty() ? "" : "did you mean " + close + "?";
  error.fix = "option4=" + (close.empty() ? names[0] : close);
  throw Failure(std::move(error));
}

class PoseEstimation {
 public:
  explicit PoseEstimation(const Options& options) : has_offsets_(read_has_offsets(options)) {
    const auto output = read_size(options, "option1", "the size of the output");
    const auto input =
        read_size(options, "option2",
                  has_offsets_ ? "the size of the model's input" : "the size of the heat map");
    output_ = {output.width, output.height};
    input_ = {input.width, input.height};
    const std::string path(options.get("option3").value_or(""));
    body_ = path.empty() ? default_key_points() : read_key_point_file("option3", path);
    body_text_ = path.empty() ? "the default key points, without option3" : "option3=" + path;
    peaks_.resize(body_.names.size());
    joints_.resize(body_.names.size());
  }

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    if (!inputs.empty()) {
      check_count(inputs.size());
      check(inputs[0], has_offsets_ ? &inputs[1] : nullptr);
    }
    output.set_caps("video/x-raw,format=(string)RGBA,width=(int)" + std::to_string(output_.width) +
                    ",height=(int)" + std::to_string(output_.height));
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    check_count(frame.n_tensors);
    const weir_tensor* tensors = frame.tensors;
    const detection::HeatGrid grid =
        check(tensors[0].info, has_offsets_ ? &tensors[1].info : nullptr);
    detection::find_peaks(maps_.read(tensors[0]), grid,
                          has_offsets_ ? detection::Heat::Logit : detection::Heat::Probability,
                          peaks_);
    const auto offsets = has_offsets_ ? offsets_.read(tensors[1]) : std::span<const float>();
    for (size_t i = 0; i < peaks_.size(); ++i)
      joints_[i] = has_offsets_ ? joint_with_offset(i, grid, offsets) : joint_of_cell(peaks_[i]);
    draw::RgbaFrame canvas(output.reserve(draw::rgba_bytes(output_)), output_);
    canvas.clear();
    draw::draw_skeleton(canvas, joints_, body_.bones, draw::kWhite);
    draw::draw_names(canvas, joints_, body_.names, draw::kWhite);
    return true;
  }

 private:
  void check_count(size_t tensors) const {
    if (tensors >= (has_offsets_ ? 2u : 1u)) return;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "mode=pose_estimation needs more tensors",
                   .offered = std::to_string(tensors) + (tensors == 1 ? " tensor" : " tensors"),
                   .needed = needed(),
                   .fix = has_offsets_ ? "option4=heatmap-only for a model without offsets"
                                       : "tensor_filter output-combination=o0"});
  }
  std::string needed() const {
    const size_t points = body_.names.size();
    std::string text = "float32 " + std::to_string(points) + ":W:H";
    if (has_offsets_) text += ", then float32 " + std::to_string(2 * points) + ":W:H";
    return text + " for " + body_text_;
  }

  // Returns the grid; throws Failure for tensors that are not heat maps and offsets.
  detection::HeatGrid check(const weir_tensor_info& maps, const weir_tensor_info* offsets) const {
    const auto points = static_cast<int64_t>(body_.names.size());
    if (!is_map(maps))
      throw wrong_tensor("the first tensor is not a heat map", maps,
                         maps.type == WEIR_FLOAT32
                             ? "tensor_filter output-combination=o0, or the output of heat maps"
                             : model_.float32_elements());
    if (dimension(maps, 0) != points)
      throw wrong_tensor(
          "the heat map has a different number of key points than the body", maps,
          "option3=/path/to/a file of " + std::to_string(dimension(maps, 0)) + " lines");
    const detection::HeatGrid grid{static_cast<size_t>(points),
                                   static_cast<size_t>(dimension(maps, 1)),
                                   static_cast<size_t>(dimension(maps, 2))};
    if (!offsets) return grid;
    if (!is_map(*offsets) || dimension(*offsets, 0) != 2 * points ||
        dimension(*offsets, 1) != dimension(maps, 1) ||
        dimension(*offsets, 2) != dimension(maps, 2))
      throw wrong_tensor("the second tensor does not hold the offsets of the heat map", *offsets,
                         "tensor_filter output-combination=o0,o1");
    if (grid.width < 2 || grid.height < 2)
      throw wrong_tensor("a heat map with offsets has too few cells", maps, "option4=heatmap-only",
                         ", at least 2 columns and 2 rows");
    return grid;
  }
  static bool is_map(const weir_tensor_info& info) {
    bool good = info.type == WEIR_FLOAT32;
    for (uint32_t i = 0; i < 3; ++i) good &= dimension(info, i) > 0;
    for (uint32_t i = 3; i < WEIR_RANK_LIMIT; ++i) good &= dimension(info, i) == 1;
    return good;
  }
  Failure wrong_tensor(const char* what, const weir_tensor_info& info, std::string fix,
                       const std::string& more_needed = "") const {
    return Failure({.code = Code::SPEC_MISMATCH,
                    .what = what,
                    .offered = describe(info),
                    .needed = needed() + more_needed,
                    .fix = std::move(fix)});
  }

  draw::Joint joint_of_cell(const detection::HeatPeak& peak) const {
    if (!(peak.probability >= kMinProbability)) return std::nullopt;
    const auto place = [](uint32_t cell, uint32_t output, uint32_t cells) {
      return std::min<int64_t>(int64_t{cell} * output / cells, output);
    };
    return draw::PixelPoint{place(peak.column, output_.width, input_.width),
                            place(peak.row, output_.height, input_.height)};
  }

  draw::Joint joint_with_offset(size_t index, const detection::HeatGrid& grid,
                                std::span<const float> offsets) const {
    const detection::HeatPeak& peak = peaks_[index];
    if (!(peak.probability >= kMinProbability)) return std::nullopt;
    const auto at = detection::position_with_offset(peak, grid, offsets, index, input_);
    if (!std::isfinite(at.x) || !std::isfinite(at.y)) throw no_position(index, at);
    const auto place = [](float position, uint32_t output, uint32_t input) {
      const auto max = static_cast<float>(output);
      return static_cast<int64_t>(std::clamp(position * max / static_cast<float>(input), 0.f, max));
    };
    return draw::PixelPoint{place(at.x, output_.width, input_.width),
                            place(at.y, output_.height, input_.height)};
  }
  Failure no_position(size_t index, const detection::PosePoint& at) const {
    const auto& peak = peaks_[index];
    return Failure({.code = Code::SPEC_MISMATCH,
                    .what = "the key point " + body_.names[index] + " has no position",
                    .offered = "x " + std::to_string(at.x) + ", y " + std::to_string(at.y) +
                               " with the offsets of cell " + std::to_string(peak.column) + ", " +
                               std::to_string(peak.row),
                    .needed = "offsets that are finite numbers of pixels",
                    .fix = "option4=heatmap-only"});
  }

  bool has_offsets_;
  Size output_;
  Size input_;
  KeyPoints body_;
  std::string body_text_;  // where the key points come from
  StreamModel model_;
  TensorValues maps_, offsets_;
  std::vector<detection::HeatPeak> peaks_;
  std::vector<draw::Joint> joints_;
};

}  // namespace

const weir_decoder_type& pose_estimation() {
  static const weir_decoder_type table =
      decoder_table<PoseEstimation>("pose_estimation", "", kPoseOptions);
  return table;
}

}  // namespace weir::decoders
