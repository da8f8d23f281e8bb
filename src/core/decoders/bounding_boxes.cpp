// Draws the detections of any scheme (docs/compatibility/decoder.md 5.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>

#include "core/decoders/box_scheme.hpp"
#include "core/decoders/option_text.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/detection/centroid_tracker.hpp"
#include "core/detection/pixel_box.hpp"
#include "core/draw/rgba_frame.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/decoder.hpp"
#include "weir/label_file.hpp"

namespace weir::decoders {
namespace {

// The box has its centre at x, y; its corners are scaled from `input` to `output` and truncated to
// whole pixels.
void draw_rotated(const detection::PixelBox& box, Size input, Size output,
                  draw::RgbaFrame* frame) noexcept {
  struct Point {
    double x, y;
  };
  const double half_width = box.width / 2.0, half_height = box.height / 2.0;
  const double cosine = std::cos(double{box.angle}), sine = std::sin(double{box.angle});
  std::array<Point, 4> corners{{{-half_width, -half_height},
                                {half_width, -half_height},
                                {half_width, half_height},
                                {-half_width, half_height}}};
  for (Point& corner : corners)
    corner = {(box.x + corner.x * cosine - corner.y * sine) * output.width / input.width,
              (box.y + corner.x * sine + corner.y * cosine) * output.height / input.height};
  for (size_t i = 0; i < corners.size(); ++i) {
    const Point &from = corners[i], &to = corners[(i + 1) % corners.size()];
    frame->line(static_cast<int64_t>(from.x), static_cast<int64_t>(from.y),
                static_cast<int64_t>(to.x), static_cast<int64_t>(to.y), draw::kRed);
  }
}

constexpr char kBoxOptions[] =
    R"([{"name":"option1","type":"string","default":"","help":"Scheme of the model"},)"
    R"({"name":"option2","type":"file","default":"","help":"Label file: one label per line"},)"
    R"({"name":"option3","type":"string","default":"","help":"Parameters of the scheme"},)"
    R"({"name":"option4","type":"string","default":"","help":"Size of the output, W:H"},)"
    R"({"name":"option5","type":"string","default":"","help":"Size of the model's input, W:H"},)"
    R"({"name":"option6","type":"string","default":"0","help":"1: number objects from frame to frame"},)"
    R"({"name":"option7","type":"string","default":"0","help":"1: log the boxes of each frame"}])";

constexpr int kLabelRise = 14;  // pixels from the top of a label to the top of its box

// "%.4f" in every locale.
std::string four_decimals(float value) {
  char text[64];  // 39 digits before the point
  const auto end =
      std::to_chars(std::begin(text), std::end(text), value, std::chars_format::fixed, 4);
  return {text, end.ptr};
}

// The 1 pixel outline of an upright box, in pixels of the output.
struct Outline {
  int64_t left, top, right, bottom;
};

class BoundingBoxes {
 public:
  explicit BoundingBoxes(const Options& options) {
    const auto text = [&](const char* option) {
      return std::string(options.get(option).value_or(""));
    };
    SchemeOptions scheme;
    scheme.name = text("option1");
    scheme.parameters = text("option3");
    check_scheme(scheme.name);
    const Size output = read_size(options, "option4", "the size of the output");
    const Size input = read_size(options, "option5", "the size of the model's input");
    size_ = {output.width, output.height};
    scheme.input = input_ = {input.width, input.height};
    if (const std::string path = text("option2"); !path.empty()) {
      labels_ = read_label_file("option2", path);
      scheme.labels = labels_.size();
    }
    tracks_ = read_switch(options, "option6");
    logs_ = read_switch(options, "option7");
    scheme_ = open_scheme(scheme);
  }

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    const auto described = model_.with_quantisation(inputs);
    std::vector<const weir_tensor_info*> infos;
    infos.reserve(described.size());
    for (const weir_tensor_info& info : described) infos.push_back(&info);
    if (!inputs.empty()) check(infos);
    output.set_caps("video/x-raw,format=(string)RGBA,width=(int)" + std::to_string(size_.width) +
                    ",height=(int)" + std::to_string(size_.height));
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    const auto tensors = model_.with_quantisation({frame.tensors, frame.n_tensors});
    if (!are_checked(tensors)) {
      std::vector<const weir_tensor_info*> infos;
      for (const weir_tensor& tensor : tensors) infos.push_back(&tensor.info);
      check(infos);
    }
    const detection::PixelBoxes boxes = scheme_->find(tensors);
    if (tracks_) numbers_ = tracker_.follow(boxes);
    if (logs_) log(boxes);
    draw::RgbaFrame canvas(output.reserve(draw::rgba_bytes(size_)), size_);
    canvas.clear();
    for (size_t i = 0; i < boxes.size(); ++i) draw_box(boxes[i], i, canvas);
    return true;
  }

  void reset() noexcept {
    tracker_.reset();
    reported_class_ = false;
  }

 private:
  // Frames have the same shapes for most streams.
  bool are_checked(std::span<const weir_tensor> tensors) const noexcept {
    return !tensors.empty() &&
           std::equal(tensors.begin(), tensors.end(), checked_.begin(), checked_.end(),
                      [](const weir_tensor& tensor, const weir_tensor_info& info) {
                        return tensor.info.type == info.type && tensor.info.rank == info.rank &&
                               std::equal(std::begin(info.shape), std::end(info.shape),
                                          std::begin(tensor.info.shape));
                      });
  }
  void check(std::span<const weir_tensor_info* const> infos) {
    checked_.clear();
    scheme_->check(infos);
    for (const weir_tensor_info* info : infos) checked_.push_back(*info);
  }

  bool has_label(const detection::PixelBox& box) const noexcept {
    return box.class_index >= 0 && static_cast<size_t>(box.class_index) < labels_.size();
  }

  void draw_box(const detection::PixelBox& box, size_t index, draw::RgbaFrame& canvas) {
    if (!labels_.empty() && !has_label(box)) {
      report_class(box.class_index);
      return;
    }
    if (scheme_->is_rotated()) {
      draw_rotated(box, input_, size_, &canvas);
      return;
    }
    const Outline outline = make_outline(box);
    canvas.outline(outline.left, outline.top, outline.right, outline.bottom, draw::kRed);
    if (labels_.empty()) return;
    const std::string& label = labels_[static_cast<size_t>(box.class_index)];
    canvas.text(outline.left, std::max<int64_t>(0, outline.top - kLabelRise),
                tracks_ ? label + "-" + std::to_string(numbers_[index]) : label, draw::kRed);
  }
  Outline make_outline(const detection::PixelBox& box) const noexcept {
    const auto to_output = [](int64_t at, int64_t output, int64_t input) {
      return output * at / input;
    };
    const int64_t right = int64_t{box.x} + box.width, bottom = int64_t{box.y} + box.height;
    return {
        .left = to_output(box.x, size_.width, input_.width),
        .top = to_output(box.y, size_.height, input_.height),
        .right = std::min<int64_t>(size_.width - 1, to_output(right, size_.width, input_.width)),
        .bottom =
            std::min<int64_t>(size_.height - 1, to_output(bottom, size_.height, input_.height))};
  }

  // Once, since every frame of a stream may have such boxes.
  void report_class(int32_t class_index) {
    if (reported_class_) return;
    reported_class_ = true;
    const std::string text = "boxes of class " + std::to_string(class_index) +
                             " are not drawn: the label file has " +
                             std::to_string(labels_.size()) + " labels";
    module_host->log(WEIR_LOG_WARNING, "bounding_boxes", text.c_str());
  }

  void log(const detection::PixelBoxes& boxes) const {
    const auto write = [](const std::string& text) {
      module_host->log(WEIR_LOG_INFO, "bounding_boxes", text.c_str());
    };
    write("Detect " + std::to_string(boxes.size()) + " boxes in " + std::to_string(input_.width) +
          " x " + std::to_string(input_.height) + " input image");
    for (const detection::PixelBox& box : boxes) {
      const std::string label = has_label(box) ? labels_[static_cast<size_t>(box.class_index)]
                                               : std::to_string(box.class_index);
      write("[" + label + "] x:" + std::to_string(box.x) + " y:" + std::to_string(box.y) +
            " w:" + std::to_string(box.width) + " h:" + std::to_string(box.height) +
            " prob:" + four_decimals(box.probability));
    }
  }

  Size size_;
  Size input_;
  std::vector<std::string> labels_;
  bool tracks_ = false, logs_ = false;
  std::unique_ptr<BoxScheme> scheme_;
  StreamModel model_;
  detection::CentroidTracker tracker_;
  std::vector<uint64_t> numbers_;  // of the boxes of the frame, by the tracker
  bool reported_class_ = false;
  std::vector<weir_tensor_info> checked_;  // accepted last by the scheme; their names may dangle
};

}  // namespace

const weir_decoder_type& bounding_boxes() {
  static const weir_decoder_type table =
      decoder_table<BoundingBoxes>("bounding_boxes", "bounding_box", kBoxOptions);
  return table;
}

}  // namespace weir::decoders
