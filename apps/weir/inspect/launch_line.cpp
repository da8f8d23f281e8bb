// Builds a pipeline: pictures come from videotestsrc, everything else from /dev/zero via
// tensor_converter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "inspect/launch_line.hpp"

#include <algorithm>
#include <optional>

#include "core/tensor/frame_spec.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr int64_t kAnySide = 224;  // pixels, for models that accept any picture size
constexpr int64_t kMinSide = 8;    // a smaller "picture" is more likely a table
constexpr int kFrames = 30;

struct Picture {
  int64_t batch, width, height, channels;
  bool planar;  // channels outermost: NCHW
};

constexpr Picture kAnyPicture{1, kAnySide, kAnySide, 3, false};

bool is_channels(int64_t n) {
  return n == 1 || n == 3 || n == 4;
}
bool is_side(int64_t n) {
  return n < 0 || n >= kMinSide;
}
int64_t side_or(int64_t n) {
  return n < 0 ? kAnySide : n;
}

std::optional<Picture> find_picture(const std::vector<weir_tensor_info>& inputs) {
  if (inputs.size() != 1) return std::nullopt;
  const auto& info = inputs[0];
  if (info.rank != 3 && info.rank != 4) return std::nullopt;
  const int64_t* s = info.shape + (info.rank - 3);
  const int64_t batch = info.rank == 4 ? std::max<int64_t>(info.shape[0], 1) : 1;
  if (info.layout != WEIR_LAYOUT_NCHW && is_channels(s[2]) && is_side(s[0]) && is_side(s[1]))
    return Picture{batch, side_or(s[1]), side_or(s[0]), s[2], false};
  if (info.layout != WEIR_LAYOUT_NHWC && is_channels(s[0]) && is_side(s[1]) && is_side(s[2]))
    return Picture{batch, side_or(s[2]), side_or(s[1]), s[0], true};
  return std::nullopt;
}

// Converts uint8 pixels to the model's type; "" when none is needed.
std::string conversion_to(ElementType type) {
  switch (type) {
    case ElementType::UInt8:
      return "";
    case ElementType::Int8:
      return " ! tensor_transform mode=arithmetic option=typecast:int16,add:-128"
             " ! tensor_transform mode=typecast option=int8";
    case ElementType::End:
    case ElementType::Float32:
      return " ! tensor_transform mode=arithmetic option=typecast:float32,div:255.0";
    default:
      return " ! tensor_transform mode=typecast option=" + std::string(to_string(type));
  }
}

std::string picture_source(const Picture& p, ElementType type) {
  const char* format = p.channels == 1 ? "GRAY8" : p.channels == 3 ? "RGB" : "RGBA";
  std::string out = "videotestsrc num-buffers=" + std::to_string(kFrames * p.batch) +
                    " ! video/x-raw,format=" + format + ",width=" + std::to_string(p.width) +
                    ",height=" + std::to_string(p.height) + ",framerate=30/1 ! tensor_converter";
  if (p.batch > 1) out += " frames-per-tensor=" + std::to_string(p.batch);
  if (p.planar) out += " ! tensor_transform mode=transpose option=1:2:0:3";
  return out + conversion_to(type);
}

TensorSpec chosen(const weir_tensor_info& info) {
  TensorSpec spec;
  spec.type =
      info.type < WEIR_TYPE_END ? static_cast<ElementType>(info.type) : ElementType::Float32;
  const uint32_t rank = info.rank == WEIR_RANK_UNKNOWN ? 0 : info.rank;
  for (uint32_t i = 0; i < rank; ++i)
    spec.shape[i] = static_cast<uint32_t>(std::max<int64_t>(info.shape[rank - 1 - i], 1));
  if (rank == 0) spec.shape[0] = 1;
  return spec;
}

std::string bytes_source(const std::vector<weir_tensor_info>& inputs) {
  std::vector<TensorSpec> specs;
  uint64_t bytes = 0;
  for (const auto& info : inputs) {
    specs.push_back(chosen(info));
    bytes += specs.back().bytes().value_or(0);
  }
  return "filesrc location=/dev/zero blocksize=" + std::to_string(bytes) +
         " num-buffers=" + std::to_string(kFrames) +
         " ! application/octet-stream ! tensor_converter input-dim=" + join_shapes(specs) +
         " input-type=" + join_types(specs);
}

// Formats as options of `weir inspect`.
std::string chosen_options(const std::vector<weir_tensor_info>& inputs) {
  const auto chosen = chosen_inputs(inputs);
  return "--input " + join(chosen, ",", [](const auto& info) { return caps_order(info); }) +
         " --inputtype " + join(chosen, ",", [](const auto& info) { return type_name(info); });
}

}  // namespace

bool leaves_open(const weir_tensor_info& info) {
  return info.rank == WEIR_RANK_UNKNOWN || info.type >= WEIR_TYPE_END ||
         std::any_of(info.shape, info.shape + info.rank, [](int64_t n) { return n < 0; });
}

std::string caps_order(const weir_tensor_info& info) {
  if (info.rank == WEIR_RANK_UNKNOWN) return "?";
  std::string out;
  for (uint32_t i = info.rank; i-- > 0;)
    out += (out.empty() ? "" : ":") + (info.shape[i] < 0 ? "?" : std::to_string(info.shape[i]));
  return out.empty() ? "1" : out;
}

std::string inspect_command(const std::string& model, const std::string& framework,
                            const std::string& options) {
  std::string out = "weir inspect";
  if (!framework.empty()) out += " --engine " + shell_word(framework);
  out += " " + options;
  if (!model.empty()) out += " " + shell_word(model);
  return out;
}

std::string type_name(const weir_tensor_info& info) {
  if (info.type >= WEIR_TYPE_END) return "?";
  return std::string(to_string(static_cast<ElementType>(info.type)));
}

LaunchLine launch_line(const std::string& model, const std::string& framework,
                       const std::vector<weir_tensor_info>& inputs, const std::string& preparation,
                       const std::string& properties) {
  LaunchLine out;
  const auto picture = find_picture(inputs);
  const bool prepared = picture && picture->batch == 1 && !preparation.empty();
  const std::string source =
      prepared         ? "videotestsrc num-buffers=" + std::to_string(kFrames) + " ! " + preparation
      : picture        ? picture_source(*picture, static_cast<ElementType>(inputs[0].type))
      : inputs.empty() ? picture_source(kAnyPicture, ElementType::UInt8)
                       : bytes_source(inputs);
  out.command = "gst-launch-1.0 " + source + " ! tensor_filter";
  if (!framework.empty()) out.command += " framework=" + launch_value(framework);
  if (!model.empty()) out.command += " model=" + launch_value(model);
  if (!properties.empty()) out.command += " " + properties;
  out.command += " ! fakesink";
  if (std::any_of(inputs.begin(), inputs.end(), leaves_open))
    out.notes.push_back("the model leaves sizes open; the line uses " + chosen_options(inputs) +
                        "; for other sizes, run " +
                        inspect_command(model, framework, "--input DIMENSIONS --inputtype TYPES"));
  if (inputs.empty())
    out.notes.push_back("the model accepts any tensors; the line feeds pictures");
  else if (!picture)
    out.notes.push_back("the line feeds zeros; a model may need other values to run");
  if (picture && !prepared && inputs[0].type != WEIR_UINT8)
    out.notes.push_back(
        "a model card defines how pixels become numbers; without one, this line only matches the"
        " type");
  return out;
}

std::vector<weir_tensor_info> chosen_inputs(std::vector<weir_tensor_info> inputs) {
  const int64_t side = find_picture(inputs) ? kAnySide : 1;
  for (auto& info : inputs) {
    if (info.rank == WEIR_RANK_UNKNOWN) info.rank = 1, info.shape[0] = 1;
    if (info.type >= WEIR_TYPE_END) info.type = WEIR_FLOAT32;
    const bool has_batch = info.rank > 0 && info.rank != 3;
    if (has_batch && info.shape[0] < 0) info.shape[0] = 1;
    for (uint32_t i = 0; i < info.rank; ++i)
      if (info.shape[i] < 0) info.shape[i] = side;
  }
  return inputs;
}

}  // namespace weir::app
