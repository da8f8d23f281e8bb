// Opens a TorchScript file; the user's declarations complete what the graph leaves open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_model.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pytorch/torch_file.hpp"
#include "tensor_check.hpp"
#include "usable_cores.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

// Sets only what is open: where the graph contradicts the user, the host reports it.
void lay_over(const DeclaredTensor& declared, weir_tensor_info* info) {
  if (info->type == WEIR_TYPE_END) info->type = declared.type;
  if (!declared.has_shape) return;
  if (info->rank == WEIR_RANK_UNKNOWN) {
    info->rank = static_cast<uint32_t>(declared.shape.size());
    std::copy(declared.shape.begin(), declared.shape.end(), info->shape);
  } else if (info->rank == declared.shape.size()) {
    for (uint32_t i = 0; i < info->rank; ++i)
      if (info->shape[i] < 0) info->shape[i] = declared.shape[i];
  }
}

std::string example_line(const std::string& name, size_t inputs) {
  std::string dimensions, types;
  for (size_t i = 0; i < std::max<size_t>(inputs, 1); ++i) {
    dimensions += (i > 0 ? "." : "") + std::string("224:224:3:1");
    types += (i > 0 ? "." : "") + std::string("float32");
  }
  return "tensor_filter framework=pytorch model=" + name + " input=" + dimensions +
         " inputtype=" + types;
}

// Measured with 20 models of 1 to 1800 million multiplications on two cores, libtorch 1.13
// (README.md): one thread computes 40 000 million per second, waking a second thread for an
// operator and waiting for it takes about 40 us, and weights load from memory at 8 GB per second.
constexpr ThreadCosts kThreadCosts{.of_operator = 1.3e6, .of_invoke = 20e6, .of_weight = 20};

void warn_of_slow_blas() {
  if (TorchProgram::has_fast_blas()) return;
  log(WEIR_LOG_WARNING,
      "libtorch multiplies matrices with a BLAS that is many times slower than OpenBLAS: apt-get "
      "install libopenblas0-pthread");
}

}  // namespace

Result<std::unique_ptr<TorchModel>> TorchModel::open(const weir_open& request) {
  std::unique_ptr<TorchModel> model(new TorchModel);
  auto options = TorchOptions::read(request);
  if (!options) return options.error();
  model->options_ = *std::move(options);
  model->threads_ = model->options_.threads;
  auto file = ModelSource::open(request);
  if (!file) return file.error();
  // libtorch then reads the bytes that were checked. Larger files are read twice.
  if (!file->keep_small())
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the model file was truncated while it was read",
                 .offered = file->name(),
                 .needed = std::to_string(file->size()) + " bytes",
                 .fix = "open the model after it is completely written"};
  const auto compressed = check_torch_file(*file);
  if (!compressed) {
    Error error = compressed.error();
    error.offered = file->name() + ": " + error.offered;
    return error;
  }
  warn_of_slow_blas();
  auto program =
      TorchProgram::load(*file, *compressed, model->options_.freeze, model->options_.optimize);
  if (!program) return program.error();
  model->program_ = *std::move(program);
  if (auto status = model->read_inputs(file->name()); !status) return status.error();
  if (auto status = model->read_outputs(file->name()); !status) return status.error();
  const nlohmann::json metadata{{"operators", model->program_->facts().operators},
                                {"libtorch", TorchProgram::version()},
                                {"frozen", model->options_.freeze},
                                {"optimized", model->options_.freeze && model->options_.optimize}};
  model->metadata_ = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return model;
}

void TorchModel::choose_threads(std::span<const weir_tensor_info> inputs) const {
  if (options_.threads > 0) return;
  const Work work = program_->facts().work.estimate(inputs);
  threads_ = work.operators == 0 ? usable_cores() : threads_for(work, kThreadCosts, usable_cores());
}

Status TorchModel::read_inputs(const std::string& name) {
  const auto& facts = program_->facts();
  const auto& declared = options_.declared.inputs();
  if (facts.inputs.size() > WEIR_TENSOR_LIMIT || declared.size() > facts.inputs.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the model has a different number of inputs",
                 .offered = name + ": " + std::to_string(facts.inputs.size()),
                 .needed = std::to_string(std::min<size_t>(declared.size(), WEIR_TENSOR_LIMIT)),
                 .difference = "number of tensors"};
  inputs_ = facts.inputs;
  names_ = facts.input_names;
  for (size_t i = 0; i < inputs_.size(); ++i) {
    if (i < declared.size()) {
      lay_over(declared[i], &inputs_[i]);
      if (!declared[i].name.empty()) names_[i] = declared[i].name;
    }
    inputs_[i].name = names_[i].c_str();
  }
  return ok();
}

Status TorchModel::read_outputs(const std::string& name) {
  auto count = program_->facts().outputs;
  if (!count && !options_.declared.outputs().empty()) count = options_.declared.outputs().size();
  const bool known = std::all_of(inputs_.begin(), inputs_.end(), [](const auto& info) {
    return info.type != WEIR_TYPE_END && is_fixed(info);
  });
  if (!count && known) {
    const auto found = program_->dry_run(inputs_, threads());
    if (!found) return found.error();
    count = found->size();
  }
  if (!count)
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the number of outputs is decided at run time",
        .offered = name + ": " + engine::describe(std::span<const weir_tensor_info>(inputs_)),
        .needed = "the inputs' dimensions and types, for a dry run",
        .fix = example_line(name, inputs_.size())};
  if (*count == 0 || *count > WEIR_TENSOR_LIMIT)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model has more outputs than a stream can carry",
                 .offered = name + ": " + std::to_string(*count),
                 .needed = "1 to 256"};
  outputs_.assign(*count, open_tensor_info());
  return ok();
}

void TorchModel::describe(weir_model_info* info) const {
  const auto& facts = program_->facts();
  info->flags = WEIR_MODEL_FORK_UNSAFE | WEIR_MODEL_ALLOCATES_OUTPUT;
  if (facts.has_state) info->flags |= WEIR_MODEL_STATEFUL;
  if (facts.sizes_depend_on_data) info->flags |= WEIR_MODEL_DYNAMIC_OUTPUT;
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->inputs = inputs_.data();
  info->outputs = outputs_.data();
  info->alignment = info->input_padding = 0;  // the kernels accept any address
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = facts.has_state ? 1 : 0;  // attributes belong to the module
  info->max_in_flight = 1;
  info->preferred_batch = 1;
  info->weight_bytes = facts.weight_bytes;
  info->metadata_json = metadata_.c_str();
}

}  // namespace weir::engine
