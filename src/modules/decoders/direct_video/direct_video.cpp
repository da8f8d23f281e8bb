// direct_video decoder: turns a tensor of pixels into a raw video frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <string>
#include <vector>

#include "weir/decoder.hpp"
#include "weir/join.hpp"

namespace {

using weir::Code;
using weir::Failure;

constexpr char kOptions[] =
    R"([{"name":"option1","type":"string","default":"","help":"Video format; by default GRAY8, RGB or BGRx"}])";

struct Format {
  const char* name;
  int64_t channels;
  size_t bytes;  // of one channel
};
// The first format with a given number of channels is its default.
constexpr std::array kFormats{
    Format{"GRAY8", 1, 1}, Format{"GRAY16_LE", 1, 2}, Format{"GRAY16_BE", 1, 2},
    Format{"RGB", 3, 1},   Format{"BGR", 3, 1},       Format{"BGRx", 4, 1},
    Format{"RGBx", 4, 1},  Format{"xRGB", 4, 1},      Format{"xBGR", 4, 1},
    Format{"RGBA", 4, 1},  Format{"BGRA", 4, 1},      Format{"ARGB", 4, 1},
    Format{"ABGR", 4, 1},
};

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

const Format* find(std::string_view name) {
  for (const auto& format : kFormats)
    if (same(format.name, name)) return &format;
  return nullptr;
}

class DirectVideo {
 public:
  explicit DirectVideo(const weir::Options& options) {
    wanted_ = options.get("option1").value_or("");
    chosen_ = find(wanted_);
  }

  void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output) {
    if (inputs.empty())
      throw Failure({.code = Code::FORMAT_UNSUPPORTED,
                     .what = "mode=direct_video needs the size of the picture",
                     .offered = "a flexible stream, in which each frame has its own dimensions",
                     .needed = "a static stream",
                     .fix = "tensor_converter ! tensor_decoder"});
    const Layout layout = find_layout(inputs[0]);
    output.set_caps("video/x-raw,format=(string)" + std::string(layout.format->name) +
                    ",width=(int)" + std::to_string(layout.width) + ",height=(int)" +
                    std::to_string(layout.height) +
                    ",views=(int)1,interlace-mode=(string)progressive");
  }

  // GStreamer pads rows to a multiple of 4 bytes.
  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    if (frame.n_tensors == 0)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "mode=direct_video got a frame without tensors",
                     .needed = "one picture"});
    const weir_tensor& tensor = frame.tensors[0];
    const Layout layout = find_layout(tensor.info);
    warn_if_not_as_wanted(*layout.format);
    const size_t row =
        static_cast<size_t>(layout.width * layout.format->channels) * layout.format->bytes;
    const size_t stride = (row + 3) / 4 * 4, height = static_cast<size_t>(layout.height);
    if (tensor.bytes != row * height)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "the frame does not have the size of its shape",
                     .offered = std::to_string(tensor.bytes) + " bytes",
                     .needed = std::to_string(row * height)});
    if (row == stride) {
      output.share_input(0);
      return true;
    }
    std::byte* to = output.reserve(stride * height).data();
    const auto* from = static_cast<const std::byte*>(tensor.data);
    for (size_t y = 0; y < height; ++y, to += stride, from += row) {
      std::memcpy(to, from, row);
      std::memset(to + row, 0, stride - row);
    }
    return true;
  }

 private:
  struct Layout {
    const Format* format;
    int64_t width, height;
  };

  Layout find_layout(const weir_tensor_info& info) const {
    const int64_t channels = weir::dimension(info, 0);
    const size_t bytes = weir::element_bytes(info.type);
    const auto fits = [&](const Format& f) { return f.channels == channels && f.bytes == bytes; };
    const Format* format = chosen_ && fits(*chosen_) ? chosen_ : nullptr;
    if (!format) {
      const auto found = std::find_if(kFormats.begin(), kFormats.end(), fits);
      if (found != kFormats.end()) format = &*found;
    }
    const int64_t width = weir::dimension(info, 1), height = weir::dimension(info, 2);
    bool one_picture = width > 0 && height > 0 && width <= INT32_MAX && height <= INT32_MAX;
    for (uint32_t i = 3; i < WEIR_RANK_LIMIT; ++i) one_picture &= weir::dimension(info, i) == 1;
    if (!format || !one_picture)
      throw Failure({.code = Code::SPEC_MISMATCH,
                     .what = "mode=direct_video needs one picture",
                     .offered = weir::describe(info),
                     .needed = "1, 3 or 4 channels : width : height of uint8 or int8, or 1 channel "
                               "of uint16 or int16" +
                               std::string(is_real(info) ? "; the fix takes 0 to 1 as the range "
                                                           "of the values"
                                                         : ""),
                     .fix = elements_for(info)});
    return {format, width, height};
  }

  static bool is_real(const weir_tensor_info& info) {
    return info.type == WEIR_FLOAT16 || info.type == WEIR_FLOAT32 || info.type == WEIR_FLOAT64;
  }

  // The elements that make pixels of a tensor; "" if it has no dimensions of a picture.
  static std::string elements_for(const weir_tensor_info& info) {
    const auto are_channels = [](int64_t extent) {
      return extent == 1 || extent == 3 || extent == 4;
    };
    const bool is_packed = are_channels(weir::dimension(info, 0));
    if (!is_packed && !are_channels(weir::dimension(info, 2))) return "";
    std::string out;
    if (!is_packed) out += "tensor_transform mode=transpose option=2:0:1:3 ! ";
    if (is_real(info))
      out += "tensor_transform mode=arithmetic option=typecast:float32,mul:255.0 ! ";
    if (info.type != WEIR_UINT8)
      out +=
          "tensor_transform mode=clamp option=0:255 ! "
          "tensor_transform mode=typecast option=uint8 ! ";
    return out.empty() ? "" : out + "tensor_decoder";
  }

  // Logs an unusable option1 instead of failing, because pipelines with such an option have always
  // run. Waits for the first frame: the host also opens and configures decoders to answer queries.
  void warn_if_not_as_wanted(const Format& made) {
    if (reported_ || wanted_.empty() || chosen_ == &made) return;
    reported_ = true;
    std::vector<std::string_view> names;
    for (const auto& format : kFormats)
      if (format.channels == made.channels && format.bytes == made.bytes)
        names.push_back(format.name);
    const std::string text = "mode=direct_video outputs " + std::string(made.name) +
                             " instead of option1=" + wanted_ + ": this tensor can become one of " +
                             weir::join(names, ", ");
    weir::module_host->log(WEIR_LOG_ERROR, "direct_video", text.c_str());
  }

  std::string wanted_;
  const Format* chosen_ = nullptr;
  bool reported_ = false;
};

}  // namespace

WEIR_DECODER(DirectVideo, "direct_video", "", kOptions)
