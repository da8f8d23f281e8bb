// libtorch engine: the module's entry point.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_file.hpp"
#include "pytorch/torch_model.hpp"
#include "pytorch/torch_runner.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct PytorchEngine {
  static constexpr const char *kName = "pytorch", *kAliases = "torch,libtorch",
                              *kExtensions = "pt,pth,torchscript", *kLibrary = "libtorch";
  static constexpr const char* kOptions = R"([
    {"name": "NumThreads", "type": "integer", "default": "by the work per frame", "help": "threads of one invoke"},
    {"name": "Freeze", "type": "boolean", "default": "true",
     "help": "weights become constants of the graph, which is then simplified"},
    {"name": "Optimize", "type": "boolean", "default": "true",
     "help": "optimize_for_inference: fuses layers and lays weights out for oneDNN; needs Freeze"},
    {"name": "input", "type": "text", "default": "the property input", "help": "dimensions of the inputs"},
    {"name": "inputtype", "type": "text", "default": "the property inputtype", "help": "types of the inputs"},
    {"name": "inputname", "type": "text", "default": "the property inputname", "help": "names of the inputs"},
    {"name": "output", "type": "text", "default": "the property output",
     "help": "dimensions of the outputs; gives their number if the model decides it at run time"}])";
  using Model = TorchModel;
  using Session = TorchRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    return torch_score(head);
  }
  static Result<LibraryFacts> library() {
    return LibraryFacts{TorchProgram::path(), TorchProgram::version()};
  }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::PytorchEngine)
