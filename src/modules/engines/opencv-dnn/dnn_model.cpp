// Opens a network. The user's options complete what the files do not declare, and override sizes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_model.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "dry_run.hpp"
#include "model_bytes.hpp"
#include "protobuf_reader.hpp"
#include "tensor_check.hpp"
#include "usable_cores.hpp"
#include "weir/engine_tools.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

struct DnnSource {
  DnnFiles files;
  DnnDescription description;
};

namespace fs = std::filesystem;

bool ends_in(const std::string& path, const std::string& suffix) {
  return equals_ignoring_case(fs::path(path).extension().string(), "." + suffix);
}

Error wrong_files(const std::string& offered) {
  const std::string weights = dnn_engine.weights_extension, text = dnn_engine.description_extension;
  const bool one = dnn_engine.format == DnnFormat::Tensorflow;
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string("the engine ") + dnn_engine.name + " needs different files",
               .offered = offered,
               .needed = one ? "a frozen graph (.pb), and a .pbtxt if OpenCV needs one"
                             : "one ." + text + " and one ." + weights,
               .fix = one ? "model=graph.pb" : "model=net." + text + ",net." + weights};
}

Status check_graph_head(std::span<const std::byte> head) {
  return can_begin_message(head) ? ok() : Status(describe_tensorflow(head).error());
}
Status check_caffe_head(std::span<const std::byte> head) {
  return can_begin_message(head) ? ok() : check_caffe_weights(head);
}

// The check of the first bytes of the weights; null when the format has none.
decltype(ModelLimits::check_head) weights_head() {
  if (dnn_engine.format == DnnFormat::Tensorflow) return check_graph_head;
  return dnn_engine.format == DnnFormat::Caffe ? check_caffe_head : nullptr;
}

Result<std::vector<std::byte>> read_bytes(const std::string& path, const ModelLimits& limits = {}) {
  const char* paths[] = {path.c_str()};
  weir_open one{};
  one.struct_size = sizeof one;
  one.n_models = 1;
  one.paths = paths;
  auto file = read_model(one, limits);
  if (!file) return file.error();
  return std::move(file->owned);
}

struct Paths {
  std::string description, weights;
};

// Adds the file that is not given: it has the name of the other one. `all` is for errors.
Result<Paths> with_other(Paths paths, const std::string& all) {
  const bool has_weights = !paths.weights.empty();
  fs::path beside = has_weights ? paths.weights : paths.description;
  beside.replace_extension(has_weights ? dnn_engine.description_extension
                                       : dnn_engine.weights_extension);
  std::error_code ignored;
  if (!fs::is_regular_file(beside, ignored))
    return wrong_files(all + "; " + beside.string() + " is not there");
  (has_weights ? paths.description : paths.weights) = beside.string();
  return paths;
}

Result<Paths> find_paths(const weir_open& request) {
  Paths out;
  std::vector<std::string> given;
  for (uint32_t i = 0; request.paths && i < request.n_models; ++i)
    if (request.paths[i] && *request.paths[i]) given.emplace_back(request.paths[i]);
  if (given.empty()) return wrong_files("no file");
  const std::string all = join(given, ", ");
  for (const auto& path : given) {
    const bool description = ends_in(path, dnn_engine.description_extension);
    std::string& place = description ? out.description : out.weights;
    if (!place.empty()) return wrong_files(all);
    place = path;
  }
  if (dnn_engine.format == DnnFormat::Tensorflow)
    return out.weights.empty() ? Result<Paths>(wrong_files(all)) : out;
  return out.description.empty() || out.weights.empty() ? with_other(std::move(out), all) : out;
}

Result<DnnDescription> described(const DnnFiles& files) {
  const std::string_view text(reinterpret_cast<const char*>(files.description.data()),
                              files.description.size());
  const std::span<const std::byte> weights(files.weights);
  if (files.format == DnnFormat::Tensorflow) return describe_tensorflow(weights);
  if (files.format == DnnFormat::Darknet) return describe_darknet(text);
  auto out = describe_caffe(text);
  if (!out) return out;
  if (auto status = check_caffe_weights(weights); !status) return status.error();
  return out;
}

// One file is enough if the other has the same path with its own extension. Checks everything that
// can be checked before OpenCV reads the files.
Result<DnnSource> read_dnn_files(const weir_open& request) {
  const auto paths = find_paths(request);
  if (!paths) return paths.error();
  DnnSource out;
  out.files.format = dnn_engine.format;
  out.files.name = paths->weights;
  auto weights = read_bytes(paths->weights, {.check_head = weights_head()});
  if (!weights) return weights.error();
  out.files.weights = *std::move(weights);
  if (!paths->description.empty()) {
    auto description = read_bytes(paths->description);
    if (!description) return description.error();
    out.files.description = *std::move(description);
  }
  auto description = described(out.files);
  if (!description) {
    Error error = description.error();
    const auto& file =
        error.what.find("description") != std::string::npos ? paths->description : paths->weights;
    error.offered = file + (error.offered.empty() ? "" : ": " + error.offered);
    return error;
  }
  out.description = *std::move(description);
  return out;
}

std::string list(const std::vector<std::string>& names) {
  constexpr size_t kMax = 12;
  const std::string out = join(std::span(names).first(std::min(names.size(), kMax)), ", ");
  return names.size() > kMax ? out + " and " + std::to_string(names.size() - kMax) + " more" : out;
}

Error no_such_name(const char* property, const std::string& name,
                   const std::vector<std::string>& known) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string(property) + " names a layer that the network lacks",
               .offered = name,
               .needed = "one of: " + list(known),
               .fix = known.empty() ? "" : std::string(property) + "=" + known.back()};
}

// The tensor "input:0" of TensorFlow's own interface is the node "input".
std::string node_name(const std::string& name) {
  return dnn_engine.format == DnnFormat::Tensorflow ? name.substr(0, name.find(':')) : name;
}

weir_tensor_info to_info(const DeclaredTensor& tensor) {
  weir_tensor_info info = open_tensor_info();
  info.type = tensor.type == WEIR_TYPE_END ? uint32_t{WEIR_FLOAT32} : tensor.type;
  if (tensor.has_shape) set_shape(&info, tensor.shape.begin(), tensor.shape.size());
  return info;
}

std::vector<std::string> get_names(const std::vector<DeclaredTensor>& tensors) {
  std::vector<std::string> out;
  out.reserve(tensors.size());
  for (const auto& tensor : tensors) out.push_back(tensor.name);
  return out;
}

// The network's inputs: those that the user names, in that order, then the others.
Result<std::vector<DeclaredTensor>> inputs_in_order(std::vector<DeclaredTensor> inputs,
                                                    const std::vector<DeclaredTensor>& declared) {
  const auto known = get_names(inputs);
  auto rest = inputs.begin();
  for (const auto& tensor : declared) {
    if (tensor.name.empty()) continue;
    const auto name = node_name(tensor.name);
    const auto at =
        std::find_if(rest, inputs.end(), [&](const auto& input) { return input.name == name; });
    if (at == inputs.end()) return no_such_name("inputname", name, known);
    std::rotate(rest, at, at + 1);
    ++rest;
  }
  return inputs;
}

// What the user says of a tensor counts.
void override_with(const DeclaredTensor& declared, DeclaredTensor* tensor) {
  if (declared.type != WEIR_TYPE_END) tensor->type = declared.type;
  if (declared.has_shape) tensor->shape = declared.shape, tensor->has_shape = true;
}

// The layer that has the output of the node `name`: OpenCV leaves out nodes that only pass it on.
Result<std::string> find_layer(const std::string& name, const DnnDescription& description,
                               const std::vector<std::string>& layers) {
  std::string out = name;
  const auto is_layer = [&] {
    return std::find(layers.begin(), layers.end(), out) != layers.end();
  };
  for (size_t steps = description.passed.size(); steps > 0 && !is_layer(); --steps)
    if (const auto to = description.passed.find(out); to != description.passed.end())
      out = to->second;
  if (!is_layer()) return no_such_name("outputname", name, layers);
  return out;
}

}  // namespace

Status DnnModel::read_options(const weir_open& request) {
  constexpr int kThreadLimit = 1024;
  threads_ = request.threads > 0 ? std::min<int>(request.threads, kThreadLimit) : usable_cores();
  for (uint32_t i = 0; request.options && i < request.n_options; ++i) {
    const auto key = text_or_empty(request.options[i].key);
    const auto value = text_or_empty(request.options[i].value);
    if (equals_ignoring_case(key, "NumThreads")) {
      const auto threads = number_option(key, value, 1);
      if (!threads) return threads.error();
      threads_ = std::min(*threads, kThreadLimit);
      keeps_threads_ = true;
      continue;
    }
    const auto taken = declared_.take(key, value);
    if (!taken) return taken.error();
    if (!*taken) warn_unknown_option(key, "NumThreads");
  }
  return ok();
}

Result<std::unique_ptr<DnnModel>> DnnModel::open(const weir_open& request) {
  std::unique_ptr<DnnModel> model(new DnnModel);
  if (auto status = model->read_options(request); !status) return status.error();
  auto source = read_dnn_files(request);
  if (!source) return source.error();
  model->weight_bytes_ = source->files.weights.size();
  model->nhwc_ = source->description.nhwc;
  if (auto status = model->read_inputs(source->description); !status) return status.error();
  if (!model->keeps_threads_ && request.threads <= 0 && model->is_small()) model->threads_ = 1;
  auto net = DnnNet::read(source->files, model->threads_);
  if (!net) return net.error();
  model->net_ = *std::move(net);
  if (auto status = model->read_outputs(source->description); !status) return status.error();
  const nlohmann::json metadata{{"operators", source->description.operators},
                                {"opencv", DnnNet::version()}};
  model->metadata_ = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return model;
}

// Whether waking a second thread for each layer takes longer than it saves: whether the bytes of
// all weights times the elements of the inputs, an estimate from above, are below 1e8. P-Net of
// MTCNN for one region (0.01e9) takes 0.7 times as long with one thread as with two, R-Net
// (0.7e9) 1.2 times, P-Net for a picture of 100x100 (0.9e9) 1.5 times. False if sizes are unknown.
bool DnnModel::is_small() const {
  constexpr double kLimit = 1e8;
  double elements = 0;
  for (const auto& input : inputs_) {
    if (!is_fixed(input)) return false;
    elements += std::accumulate(input.shape, input.shape + input.rank, 1.0, std::multiplies<>());
  }
  return static_cast<double>(weight_bytes_) * elements < kLimit;
}

weir_execution DnnModel::execution() const {
  const int threads = keeps_threads_ ? threads_ : DnnNet::threads();
  return {sizeof(weir_execution), static_cast<uint32_t>(threads), 0};
}

Status DnnModel::read_inputs(const DnnDescription& description) {
  const auto& declared = declared_.inputs();
  auto chosen = inputs_in_order(description.inputs, declared);
  if (!chosen) return chosen.error();
  if (chosen->empty() || chosen->size() > WEIR_TENSOR_LIMIT || declared.size() > chosen->size())
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the network has a different number of inputs",
        .offered = std::to_string(chosen->size()) + ": " + list(get_names(description.inputs)),
        .needed = std::to_string(std::max<size_t>(declared.size(), 1)),
        .difference = "number of tensors"};
  for (size_t i = 0; i < declared.size(); ++i) override_with(declared[i], &(*chosen)[i]);
  input_names_ = get_names(*chosen);
  for (size_t i = 0; i < chosen->size(); ++i) {
    inputs_.push_back(to_info((*chosen)[i]));
    inputs_[i].name = input_names_[i].c_str();
    if (inputs_[i].rank == 4) inputs_[i].layout = nhwc_ ? WEIR_LAYOUT_NHWC : WEIR_LAYOUT_NCHW;
  }
  return ok();
}

Status DnnModel::name_outputs(const DnnDescription& description) {
  const auto layers = net_->layers();
  for (const auto& output : declared_.outputs()) {
    if (output.name.empty()) continue;
    auto name = find_layer(node_name(output.name), description, layers);
    if (!name) return name.error();
    output_names_.push_back(*std::move(name));
  }
  // Layers that OpenCV inserts are not in TensorFlow's graph.
  if (output_names_.empty())
    for (const auto& name : net_->ends())
      if (description.nodes.empty() || description.nodes.contains(name))
        output_names_.push_back(name);
  if (!output_names_.empty() && output_names_.size() <= WEIR_TENSOR_LIMIT) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the network's outputs cannot be found",
               .offered = list(net_->ends()),
               .needed = "their names",
               .fix = "outputname=" + (layers.empty() ? std::string("NAME") : layers.back())};
}

Status DnnModel::read_outputs(const DnnDescription& description) {
  if (auto status = name_outputs(description); !status) return status;
  pictures_ = std::make_unique<bool[]>(output_names_.size());
  outputs_.assign(output_names_.size(), open_tensor_info());
  for (size_t i = 0; i < outputs_.size(); ++i) {
    pictures_[i] = description.pictures.contains(output_names_[i]);
    outputs_[i].name = output_names_[i].c_str();
  }
  if (!std::all_of(inputs_.begin(), inputs_.end(), is_fixed)) return ok();
  auto infos = dry_run(inputs_);
  if (!infos) return infos.error();
  outputs_ = *std::move(infos);
  return ok();
}

Result<std::vector<DnnOutput>> DnnModel::run(std::span<const weir_tensor> in) const {
  std::vector<DnnInput> inputs(in.size());
  for (size_t i = 0; i < in.size(); ++i) {
    // OpenCV has no name for Darknet's only input.
    inputs[i].name = in.size() == 1 ? "" : input_names_[i];
    inputs[i].data = in[i].data;
    inputs[i].info = in[i].info;
    inputs[i].nhwc = nhwc_;
  }
  return net_->run(inputs, output_names_, {pictures_.get(), output_names_.size()},
                   keeps_threads_ ? threads_ : 0);
}

Result<std::vector<weir_tensor_info>> DnnModel::dry_run(
    std::span<const weir_tensor_info> in) const {
  auto inputs = DryRunInputs::create(in);
  if (!inputs) return inputs.error();
  const auto made = run(inputs->tensors());
  if (!made) {
    if (made.error().code != Code::INVOKE_FAILED) return made.error();
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the network does not accept inputs of these shapes",
        .offered = engine::describe(in),
        .difference = made.error().offered +
                      (made.error().difference.empty() ? "" : " at " + made.error().difference),
        .fix = "set input= to the sizes that the network was built for"};
  }
  std::vector<weir_tensor_info> out;
  for (size_t i = 0; i < made->size(); ++i) {
    out.push_back((*made)[i].info);
    out.back().name = output_names_[i].c_str();
  }
  return out;
}

void DnnModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_FORK_UNSAFE;
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->inputs = inputs_.data();
  info->outputs = outputs_.data();
  info->alignment = info->input_padding = 0;  // inputs are copied
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = 1;  // the network has one set of layer memory
  info->max_in_flight = 1;
  info->preferred_batch = 1;
  info->weight_bytes = weight_bytes_;
  info->metadata_json = metadata_.c_str();
}

}  // namespace weir::engine
