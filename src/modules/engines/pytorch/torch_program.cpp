// Calls libtorch, in this file only: loads, freezes, inspects the graph and runs it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_program.hpp"

#include <ATen/Parallel.h>
#include <c10/core/InferenceMode.h>
#include <caffe2/serialize/inline_container.h>
#include <dlfcn.h>
#include <torch/csrc/api/include/torch/version.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/passes/inliner.h>
#include <torch/csrc/jit/serialization/import.h>

#include <algorithm>
#include <atomic>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

#include "dry_run.hpp"
#include "pytorch/source_buffer.hpp"
#include "pytorch/torch_graph.hpp"
#include "pytorch/torch_tensors.hpp"
#include "pytorch/torch_work_reader.hpp"
#include "thread_limit.hpp"
#include "weir/result.hpp"

namespace weir::engine {
namespace {

bool contains(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}

std::string_view line_at(std::string_view text, size_t at) {
  return text.substr(at, std::min(text.find('\n', at), text.size()) - at);
}

std::string_view stripped(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\n')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\n')) text.remove_suffix(1);
  return text;
}

// Traces of the interpreter end in a line such as "RuntimeError: ..."; in other texts the first
// line has the reason.
std::string_view reason_line(std::string_view text) {
  for (size_t at = text.rfind("Error: "); at != std::string_view::npos && at > 0;
       at = text.rfind("Error: ", at - 1)) {
    const size_t start = text.rfind('\n', at) + 1;
    const auto word = text.substr(start, at - start);
    if (start > 0 && std::all_of(word.begin(), word.end(), [](char c) {
          return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.';
        }))
      return line_at(text, start);
  }
  text = stripped(text);
  return line_at(text, 0);
}

// The call in the source line to which the trace points.
std::string_view failed_call(std::string_view text) {
  const size_t here = text.rfind("<--- HERE");
  if (here == std::string_view::npos) return {};
  const size_t marks = text.rfind('\n', here);
  if (marks == std::string_view::npos || marks == 0) return {};
  const size_t start = text.rfind('\n', marks - 1) + 1;
  const auto source = text.substr(start, marks - start),
             marked = text.substr(marks + 1, here - marks);
  const size_t column = marked.find('~');
  auto call = source.substr(std::min(column, source.size()));
  if (call.starts_with("return ")) call.remove_prefix(7);
  const size_t open = call.find('(');
  return open == std::string_view::npos ? std::string_view{} : stripped(call.substr(0, open));
}

// The word after `before`, up to white space or a quote.
std::string_view name_after(std::string_view text, std::string_view before) {
  const size_t at = text.find(before);
  if (at == std::string_view::npos) return {};
  auto word = text.substr(at + before.size());
  word = word.substr(0, std::min(word.find_first_of(" \n'\","), word.size()));
  while (!word.empty() && (word.back() == '.' || word.back() == ':')) word.remove_suffix(1);
  return word;
}

// "RuntimeError: mat1 and mat2 shapes cannot be multiplied (1x4 and 5x2) (in torch.linear)".
std::string torch_reason(std::string_view text) {
  std::string out(stripped(reason_line(text)));
  const auto call = failed_call(text);
  if (!call.empty() && !contains(out, call)) out += " (in " + std::string(call) + ")";
  return out;
}

// The error when loading a file fails.
Error torch_load_error(const std::string& model, std::string_view text) {
  for (const auto before :
       {"Unknown builtin op: ", "Could not find schema for ", "Unknown type name '",
        "Couldn't find an operator for ", "No such operator "}) {
    const auto missing = name_after(text, before);
    if (missing.empty()) continue;
    return Error{
        .code = Code::MODEL_UNSUPPORTED,
        .what = "the model uses an operator or class that this libtorch lacks",
        .offered = model + ": " + std::string(missing),
        .needed = "operators of libtorch itself",
        .fix =
            "export the model without it: operators of torchvision and other packages are in "
            "Python libraries"};
  }
  if (contains(text, "maximum supported version"))
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model was saved by a newer PyTorch than this libtorch",
                 .offered = model + ": " + torch_reason(text),
                 .fix = "save it with an older PyTorch, or export it to ONNX"};
  return Error{.code = Code::MODEL_INVALID,
               .what = "libtorch cannot load the model",
               .offered = model + ": " + torch_reason(text),
               .fix = "save the model again, then check it with weir inspect MODEL"};
}

// The error when running fails.
Error torch_run_error(std::string_view text) {
  if (contains(text, "can't allocate memory"))
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "libtorch has no memory for a frame",
                 .offered = torch_reason(text)};
  return Error{.code = Code::INVOKE_FAILED,
               .what = "libtorch failed on a frame",
               .offered = torch_reason(text)};
}

using torch::jit::IValue;

// Catches exceptions of libtorch, of its interpreter and of the standard library.
template <class Body, class Say>
auto caught(Body&& body, Say&& say) -> decltype(body()) {
  try {
    return body();
  } catch (const c10::Error& e) {
    return say(std::string_view(e.what_without_backtrace()));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return say(std::string_view(e.what()));
  }
}

// The BLAS that Debian's alternatives select for libtorch; it stays loaded with libtorch.
void* blas() {
  static void* const handle = dlopen("libblas.so.3", RTLD_LAZY | RTLD_NOLOAD);
  return handle;
}

// OpenMP sets the thread count per calling thread, OpenBLAS per process. Threads of libpthreadpool
// and OpenMP start here, after checking that they can.
Status use_threads(int threads) {
  thread_local int set_here = 0, started_here = 1;
  if (threads > started_here)
    if (auto status = check_thread_limit(2 * (threads - 1)); !status) return status;
  if (set_here != threads) at::set_num_threads(threads);
  if (threads > started_here) at::parallel_for(0, threads, 1, [](int64_t, int64_t) {});
  set_here = threads;
  started_here = std::max(started_here, threads);
  static std::atomic<int> set_in_blas{0};
  if (set_in_blas.exchange(threads) == threads || !blas()) return ok();
  if (const auto set = reinterpret_cast<void (*)(int)>(dlsym(blas(), "openblas_set_num_threads")))
    set(threads);
  return ok();
}

Status flatten(const IValue& value, std::vector<at::Tensor>* out) {
  if (value.isTensor()) {
    if (value.toTensor().defined()) out->push_back(dense(value.toTensor()));
  } else if (value.isTensorList()) {
    for (const auto& tensor : value.toTensorVector()) out->push_back(dense(tensor));
  } else if (value.isTuple()) {
    for (const auto& part : value.toTupleRef().elements())
      if (auto status = flatten(part, out); !status) return status;
  } else if (!value.isNone()) {
    return unsupported_value("output", value.tagKind());
  }
  return ok();
}

uint64_t bytes_of_weights(const torch::jit::Module& module) {
  uint64_t bytes = 0;
  for (const auto& tensor : module.parameters()) bytes += tensor.nbytes();
  for (const auto& tensor : module.buffers()) bytes += tensor.nbytes();
  return bytes;
}

// Compares the decompressed content of entries with their checksums.
Status check_entries(std::istream* stream, std::span<const CompressedEntry> entries,
                     const std::string& name) {
  if (entries.empty()) return ok();
  caffe2::serialize::PyTorchStreamReader reader(stream);
  for (const auto& entry : entries) {
    const auto [data, bytes] = reader.getRecord(entry.name);
    if (crc32({static_cast<const std::byte*>(data.get()), bytes}) != entry.crc)
      return Error{.code = Code::MODEL_INVALID,
                   .what = "the file is truncated, damaged or not a TorchScript model",
                   .offered = name + ": " + entry.name + " has a wrong checksum",
                   .needed = "a complete TorchScript archive",
                   .fix = "download or save the model again"};
  }
  return ok();
}

// An inlined copy; the module runs its own graph.
std::shared_ptr<torch::jit::Graph> get_graph(const torch::jit::Module& module) {
  auto graph = module.get_method("forward").graph()->copy();
  torch::jit::Inline(*graph);
  return graph;
}

Status read_interface(const torch::jit::Module& module, TorchFacts* facts) {
  const auto graph = get_graph(module);
  const auto& arguments = module.get_method("forward").function().getSchema().arguments();
  facts->work = TorchWorkReader::read(*graph);
  GraphReader reader(*graph, facts);
  for (size_t i = 1; i < arguments.size(); ++i) {
    const bool tensor = arguments[i].type()->isSubtypeOf(c10::TensorType::get());
    if (!tensor && arguments[i].default_value()) break;  // keeps its default value
    if (!tensor)
      return unsupported_value("input " + arguments[i].name(),
                               arguments[i].type()->annotation_str());
    reader.input(*graph->inputs().at(i));
  }
  reader.operators();
  if (graph->outputs().size() != 1) return unsupported_value("output", "nothing");
  auto count = count_tensors(graph->outputs()[0], graph->outputs()[0]->type());
  if (!count) return count.error();
  facts->outputs = *count;
  return ok();
}

// The inputs of forward(): over the memory of `in`, or copies of it.
Result<std::vector<IValue>> to_values(std::span<const weir_tensor> in, bool copied) {
  std::vector<IValue> values;
  values.reserve(in.size() + 1);
  for (const auto& tensor : in) {
    const auto type = to_torch(tensor.info.type);
    if (!type) return no_such_type(tensor.info);
    auto value = at::from_blob(tensor.data, {tensor.info.shape, tensor.info.rank}, *type);
    values.emplace_back(copied ? value.clone() : std::move(value));
  }
  return values;
}

// The inputs of a dry run: ones, or zeros that each tensor keeps alive.
Result<std::vector<IValue>> dry_run_values(const std::shared_ptr<DryRunInputs>& zeros, bool ones,
                                           bool copied) {
  std::vector<IValue> values;
  for (const auto& tensor : zeros->tensors()) {
    const auto type = to_torch(tensor.info.type);
    if (!type) return no_such_type(tensor.info);
    const at::IntArrayRef shape(tensor.info.shape, tensor.info.rank);
    auto value = ones ? at::ones(shape, *type)
                      : at::from_blob(
                            tensor.data, shape, [zeros](void*) {}, *type);
    values.emplace_back(copied ? value.clone() : std::move(value));
  }
  return values;
}

Result<std::vector<weir_tensor_info>> to_infos(const std::vector<at::Tensor>& tensors) {
  std::vector<weir_tensor_info> out;
  for (const auto& tensor : tensors) {
    auto info = torch_info(tensor);
    if (!info) return info.error();
    out.push_back(*info);
  }
  return out;
}

}  // namespace

struct TorchProgram::Parts {
  std::shared_ptr<torch::jit::CompilationUnit> classes;  // as loaded; see load()
  torch::jit::Module module;
  std::optional<torch::jit::Method> method;  // the forward that runs
  TorchFacts facts;

  Result<std::vector<at::Tensor>> forward(std::vector<IValue> inputs, int threads) const {
    const c10::InferenceMode inference;
    if (auto status = use_threads(threads); !status) return status.error();
    std::vector<at::Tensor> out;
    out.reserve(facts.outputs.value_or(1));
    if (auto status = flatten((*method)(std::move(inputs)), &out); !status) return status.error();
    return out;
  }
};

TorchProgram::TorchProgram(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
TorchProgram::~TorchProgram() = default;

Result<std::unique_ptr<TorchProgram>> TorchProgram::load(
    const ModelSource& file, std::span<const CompressedEntry> compressed, bool freeze,
    bool optimize) {
  using Loaded = Result<std::unique_ptr<TorchProgram>>;
  const std::string name = file.name();
  return caught(
      [&]() -> Loaded {
        SourceBuffer buffer(file);
        std::istream stream(&buffer);
        if (auto status = check_entries(&stream, compressed, name); !status) return status.error();
        stream.clear();
        stream.seekg(0);
        auto parts = std::make_unique<Parts>();
        auto& module = parts->module;
        module = torch::jit::load(stream, at::kCPU);
        module.eval();
        if (!module.find_method("forward"))
          return Error{.code = Code::MODEL_UNSUPPORTED,
                       .what = "the model has no method forward",
                       .offered = name,
                       .fix = "save a module with a method forward"};
        parts->facts.weight_bytes = bytes_of_weights(module);
        if (freeze) {
          // Inlined nodes refer to their original method for error traces. freeze() inlines in a
          // copy of the class and then deletes methods of that copy, so a trace would read freed
          // memory. Inlining first makes the nodes refer to methods of the loaded class.
          parts->classes = module._ivalue()->compilation_unit();
          torch::jit::Inline(*module.get_method("forward").graph());
          module = torch::jit::freeze(module);
        }
        if (auto status = read_interface(module, &parts->facts); !status) {
          Error error = status.error();
          error.offered = name + ": " + error.offered;
          return error;
        }
        if (freeze && optimize) module = torch::jit::optimize_for_inference(module);
        parts->facts.writes_inputs = writes_any_input(get_graph(module));
        parts->method = module.get_method("forward");
        return std::unique_ptr<TorchProgram>(new TorchProgram(std::move(parts)));
      },
      [&](std::string_view text) -> Loaded { return torch_load_error(name, text); });
}

const TorchFacts& TorchProgram::facts() const noexcept {
  return parts_->facts;
}

Result<std::vector<weir_tensor_info>> TorchProgram::dry_run(
    std::span<const weir_tensor_info> inputs, int threads) const {
  using Infos = Result<std::vector<weir_tensor_info>>;
  auto created = DryRunInputs::create(inputs);
  if (!created) return created.error();
  // Shared with the tensors, because a model with state may keep one.
  const auto zeros = std::make_shared<DryRunInputs>(*std::move(created));
  const auto attempt = [&](bool ones) {
    return caught(
        [&]() -> Infos {
          auto values = dry_run_values(zeros, ones, parts_->facts.writes_inputs);
          if (!values) return values.error();
          const auto tensors = parts_->forward(*std::move(values), threads);
          if (!tensors) return tensors.error();
          return to_infos(*tensors);
        },
        [](std::string_view text) -> Infos { return torch_run_error(text); });
  };
  auto found = attempt(false);
  if (!found && found.error().code == Code::INVOKE_FAILED)
    if (auto again = attempt(true)) return again;
  return found;
}

Status TorchProgram::run(std::span<const weir_tensor> in, std::span<weir_tensor> out,
                         int threads) const {
  return caught(
      [&]() -> Status {
        auto values = to_values(in, parts_->facts.writes_inputs || parts_->facts.keeps_inputs);
        if (!values) return values.error();
        auto tensors = parts_->forward(*std::move(values), threads);
        if (!tensors) return tensors.error();
        if (tensors->size() != out.size())
          return Error{.code = Code::INVOKE_FAILED,
                       .what = "the model returned a different number of tensors than before",
                       .offered = std::to_string(tensors->size()),
                       .needed = std::to_string(out.size())};
        for (size_t i = 0; i < out.size(); ++i)
          if (auto status = hand_over((*tensors)[i], i, in, &out[i]); !status) return status;
        return ok();
      },
      [](std::string_view text) -> Status { return torch_run_error(text); });
}

std::string TorchProgram::version() {
  return TORCH_VERSION;
}

std::string TorchProgram::path() {
  Dl_info info{};
  return dladdr(reinterpret_cast<const void*>(&at::get_num_threads), &info) && info.dli_fname
             ? info.dli_fname
             : "";
}

bool TorchProgram::has_fast_blas() {
  return at::hasMKL() || (blas() && dlsym(blas(), "openblas_get_config"));
}

}  // namespace weir::engine
