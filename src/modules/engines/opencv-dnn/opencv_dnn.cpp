// Engine caffe, tensorflow or darknet: the module's entry point; WEIR_DNN_FORMAT selects the
// format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_model.hpp"
#include "opencv-dnn/dnn_runner.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

constexpr DnnEngine kEngines[]{{DnnFormat::Caffe, "caffe", "prototxt", "caffemodel"},
                               {DnnFormat::Tensorflow, "tensorflow", "pbtxt", "pb"},
                               {DnnFormat::Darknet, "darknet", "cfg", "weights"}};
constexpr const char* kFileExtensions[]{"caffemodel,prototxt", "pb", "weights,cfg"};
constexpr auto kIndex = static_cast<size_t>(DnnFormat::WEIR_DNN_FORMAT);

}  // namespace

const DnnEngine dnn_engine = kEngines[kIndex];

namespace {

struct OpencvEngine {
  static constexpr const char *kName = kEngines[kIndex].name, *kAliases = "",
                              *kExtensions = kFileExtensions[kIndex], *kLibrary = "OpenCV";
  static constexpr const char* kOptions = R"([
    {"name": "NumThreads", "type": "integer", "default": "by the size of the model",
     "help": "threads of OpenCV, in the whole process"},
    {"name": "input", "type": "text", "default": "the property input", "help": "dimensions of the inputs"},
    {"name": "inputtype", "type": "text", "default": "the property inputtype",
     "help": "types of the stream: converted to float32"},
    {"name": "inputname", "type": "text", "default": "the property inputname", "help": "inputs in the stream's order"},
    {"name": "outputname", "type": "text", "default": "the property outputname", "help": "output layers"}])";
  using Model = DnnModel;
  using Session = DnnRunner;

  // No format has a signature at its beginning, so the file name decides.
  static int probe(const std::string& path, std::span<const unsigned char>) {
    const auto ends = [&path](const char* extension) {
      return path.ends_with(std::string(".") + extension);
    };
    return ends(dnn_engine.weights_extension) || ends(dnn_engine.description_extension) ? 50 : 0;
  }
  static Result<LibraryFacts> library() { return LibraryFacts{DnnNet::path(), DnnNet::version()}; }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::OpencvEngine)
