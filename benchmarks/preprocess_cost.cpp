// A frame of Full HD to a network's input: tensor_preprocess against the elements it stands for.
#include <gst/gst.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 5;
constexpr size_t kBytes = size_t{1920} * 1080 * 3 / 2;
constexpr char kVideo[] =
    "video/x-raw,format=NV12,width=1920,height=1080,framerate=30/1,interlace-mode=progressive,"
    "pixel-aspect-ratio=1/1,colorimetry=bt709";
constexpr char kTensor[] =
    " ! video/x-raw,format=RGB,width=640,height=640,pixel-aspect-ratio=1/1 ! tensor_converter ! "
    "tensor_transform mode=arithmetic option=typecast:float32,mul:0.00392156863 ! "
    "tensor_transform mode=transpose option=1:2:0:3 ! other/tensors,format=static";

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  ElementStage convert_first("videoconvert ! videoscale" + std::string(kTensor), kVideo, kBytes);
  ElementStage scale_first("videoscale ! videoconvert" + std::string(kTensor), kVideo, kBytes);
  ElementStage together("videoconvertscale" + std::string(kTensor), kVideo, kBytes);
  ElementStage preprocess(
      "tensor_preprocess width=640 height=640 fit=letterbox scale=0.00392156863 layout=NCHW",
      kVideo, kBytes);
  const auto costs = weir::bench::medians(
      {[&] { convert_first.push(kFrames); }, [&] { scale_first.push(kFrames); },
       [&] { together.push(kFrames); }, [&] { preprocess.push(kFrames); }},
      rounds);
  const std::vector<std::string> classic{"videoconvert ! videoscale", "videoscale ! videoconvert",
                                         "videoconvertscale"};
  for (size_t i = 0; i < classic.size(); ++i) {
    const auto ms = static_cast<int>(costs[i].cpu / kFrames * 1e6);
    weir::bench::report("Full HD NV12 to 640x640 float NCHW: CPU time",
                        classic[i] + " ..., " + std::to_string(ms) + " us",
                        costs[3].cpu / costs[i].cpu, "x", 0.25);
  }
}
