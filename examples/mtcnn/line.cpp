// Defines the networks' formats and builds the text of the pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "line.hpp"

#include <filesystem>

namespace mtcnn {
namespace {

namespace fs = std::filesystem;

struct Format {
  const char *framework, *folder, *names[3], *extension;
  bool turned, planes, fixed;
  const char* custom = "";
  bool bytes = false;
};
constexpr Format kFormats[] = {
    {"onnxruntime", "onnx", {"pnet", "rnet", "onet"}, ".onnx", false, true, false},
    {"onnxruntime", "onnx_nhwc", {"pnet", "rnet", "onet"}, ".onnx", true, false, false},
    {"pytorch", "torchscript", {"pnet", "rnet", "onet"}, ".pt", false, true, false},
    {"caffe", "caffe", {"det1", "det2", "det3"}, ".caffemodel", true, true, true},
    {"tensorflow-lite",
     "tflite",
     {"pnet", "rnet", "onet"},
     ".tflite",
     true,
     false,
     false,
     "Resize:true"},
    {"mtcnn-kernels", "onnx", {"pnet", "rnet", "onet"}, ".onnx", false, false, false, "", true},
    {"mtcnn-kernels",
     "onnx_nhwc",
     {"pnet", "rnet", "onet"},
     ".onnx",
     false,
     false,
     false,
     "",
     true},
};

// A queue limited only by this number of pictures.
std::string queue(int frames) {
  return "queue max-size-bytes=0 max-size-time=0 max-size-buffers=" + std::to_string(frames);
}

std::string size_text(const Size& size, char between) {
  return std::to_string(size.width) + between + std::to_string(size.height);
}

// Converts pictures to a network's input; `what` sets the size.
std::string prepared(const Networks& networks, const std::string& what) {
  const bool bytes = networks.bytes || networks.rounded;
  return " ! tensor_preprocess " +
         std::string(bytes ? "type=uint8" : "type=float32 mean=127.5 scale=0.0078125") +
         " layout=" + (networks.planes ? "NCHW " : "NHWC ") + what +
         (networks.bytes || !networks.rounded
              ? ""
              : " ! tensor_transform mode=arithmetic "
                "option=typecast:float32,add:-127.5,mul:0.0078125") +
         (!networks.turned  ? ""
          : networks.planes ? " ! tensor_transform mode=transpose option=1:0:2:3"
                            : " ! tensor_transform mode=transpose option=0:2:1:3");
}

// The largest batches for networks with fixed sizes; tensor_preprocess drops and counts the least
// likely of further regions.
constexpr size_t kMaxRefined = 512, kMaxMarked = 64;

std::string network(const Networks& networks, int number, const Size& input, size_t batch = 1) {
  std::string line =
      "tensor_filter framework=" + networks.framework + " model=" + networks.files[number];
  if (number == 0) line += " shared-tensor-filter-key=mtcnn-pnet";  // opened once for all layers
  if (networks.fixed) {
    const Size stored = networks.turned ? Size{input.height, input.width} : input;
    line += " input=" + size_text(stored, ':') + ":3:" + std::to_string(batch);
  }
  return line + (networks.custom.empty() ? "" : " custom=" + networks.custom);
}

// Splits a batch of regions into parts that fit a core's cache, two running at once. Only ONNX
// files declare a variable batch size.
std::string in_parts(const Networks& networks, size_t rows) {
  return networks.framework != "onnxruntime"
             ? ""
             : " invoke-threads=2 invoke-rows=" + std::to_string(rows);
}

// Runs the regions from `name`.regions as one batch through network `number`.
std::string regions(const Networks& networks, int number, const char* name, uint32_t side,
                    size_t max, size_t rows) {
  const std::string length = std::to_string(side);
  return prepared(networks, std::string("name=") + name +
                                " regions=pad clip-regions=false max-wait=60000000000" +
                                " threads=2 width=" + length + " height=" + length +
                                (networks.fixed ? " max-regions=" + std::to_string(max) : "")) +
         " ! " + network(networks, number, {side, side}, max) + in_parts(networks, rows);
}

// Runs P-Net on each of the stream's tensors with filters in a row: each consumes the first tensor,
// passes the others on, and appends its maps.
std::string chain(const Networks& networks, std::span<const Size> layers) {
  std::string line;
  for (size_t i = 0; i < layers.size(); ++i) {
    line += " ! " + network(networks, 0, layers[i]);
    if (layers.size() == 1) break;
    const size_t passed = layers.size() - 1 + i;  // remaining layers and maps so far
    std::string all;
    for (size_t k = 1; k <= passed; ++k) all += "i" + std::to_string(k) + ",";
    line += " input-combination=0 output-combination=" + all + "o0,o1";
  }
  return line;
}

std::string own_filter(const char* name) {
  return std::string(" ! tensor_filter framework=custom-easy invoke-dynamic=true model=") + name;
}

}  // namespace

weir::Result<Networks> find_networks(const std::string& framework, const std::string& folder) {
  std::string looked_for;
  for (const Format& format : kFormats) {
    if (framework != format.framework) continue;
    Networks out{.framework = framework,
                 .files = {},
                 .turned = format.turned,
                 .planes = format.planes,
                 .bytes = format.bytes,
                 .fixed = format.fixed,
                 .custom = format.custom};
    bool there = true;
    for (int i = 0; i < 3; ++i) {
      const fs::path stem = fs::path(folder) / format.folder / format.names[i];
      const std::string file = stem.string() + format.extension;
      there = there && fs::exists(file);
      out.files[i] = (framework == "caffe" ? stem.string() + ".prototxt," : "") + file;
    }
    if (there) return out;
    looked_for += (looked_for.empty() ? "" : " or ") + (fs::path(folder) / format.folder).string();
  }
  if (looked_for.empty())
    return weir::Error{.code = weir::Code::OPTION_VALUE,
                       .what = "MTCNN's networks are in no format for this framework",
                       .offered = framework,
                       .needed = "onnxruntime, mtcnn-kernels, pytorch, caffe or tensorflow-lite",
                       .fix = "--framework onnxruntime"};
  return weir::Error{.code = weir::Code::FILE_NOT_FOUND,
                     .what = "MTCNN's networks are not there",
                     .offered = looked_for,
                     .needed = "three networks of one format",
                     .fix = "examples/mtcnn/fetch"};
}

std::string networks_line(const Setup& setup, const Networks& networks, std::string_view pictures) {
  const std::span<const Size> layers = setup.layers;
  std::string sizes, others;
  for (size_t i = 0; i < layers.size(); ++i) {
    sizes += (i ? "," : "") + size_text(layers[i], 'x');
    if (i > 0) others += (i > 1 ? ":" : "") + std::to_string(i);
  }
  const std::string from = " " + std::string(pictures) + ". ! ";
  std::string line = from + queue(1) + prepared(networks, "sizes=" + sizes);
  if (layers.size() == 1)
    line += chain(networks, layers);
  else  // the largest layer is half of the work and gets its own thread
    line += " ! tensor_demux name=layers tensorpick=0," + others + "  layers.src_0 ! " + queue(1) +
            chain(networks, layers.first(1)) + " ! maps.sink_0  layers.src_1 ! " + queue(1) +
            chain(networks, layers.subspan(1)) + " ! maps.sink_1  tensor_mux name=maps";
  line += own_filter("mtcnn-proposals") + " ! " + queue(1) + " ! refined.regions ";
  line += from + queue(8) + regions(networks, 1, "refined", kRefineSide, kMaxRefined, 32) +
          own_filter("mtcnn-refinement") + " ! " + queue(1) + " ! marked.regions ";
  line += from + queue(8) + regions(networks, 2, "marked", kLandmarkSide, kMaxMarked, 8) +
          own_filter("mtcnn-landmarks");
  return line;
}

}  // namespace mtcnn
